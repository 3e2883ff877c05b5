#include "tests/support/flights/calibration_flight.h"

#include <array>
#include <cmath>
#include <optional>
#include <random>

#include "frontend/types/so3.h"
#include "residuals/lens.h"
#include "tests/support/draws.h"

namespace tagtwist::internal {
namespace {

class ErrorDraw {
 public:
  explicit ErrorDraw(unsigned seed) : rng_(seed) {}
  Eigen::Vector3d Normal3(double sigma) { return sigma * DrawVector<3>(normal_, rng_); }
  Eigen::Vector2d Normal2(double sigma) { return sigma * DrawVector<2>(normal_, rng_); }

 private:
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
};

TagMap Mat(const CalibrationFlightOptions& options) {
  TagGrid grid;
  grid.rows = options.rows;
  grid.columns = options.columns;
  grid.row_gaps_m.assign(static_cast<size_t>(options.rows - 1), grid.tag_size_m);
  grid.column_gaps_m.assign(static_cast<size_t>(options.columns - 1), grid.tag_size_m);
  return MakeTagMap(grid);
}

// The body, upright over the mat, its camera looking down.
Pose WorldFromBodyAt(double t, const CalibrationFlightOptions& options) {
  constexpr double kStepM = 0.304;
  const double length_m = kStepM * options.rows, width_m = kStepM * options.columns;
  const Eigen::Vector3d place(length_m * (0.5 + 0.3 * std::sin(0.7 * t)),
                              width_m * (0.5 + 0.3 * std::sin(0.9 * t + 1)),
                              1.3 + 0.4 * std::sin(0.6 * t + 2));
  const Eigen::Vector3d tilt(0.4 * std::sin(1.1 * t), 0.4 * std::sin(1.3 * t + 0.5), 0);
  const Eigen::Vector3d heading(0, 0, 2.5 * std::sin(0.5 * t));
  switch (options.motion) {
    case CalibrationMotion::kFree:
      return MakePose(ExpSo3(heading) * ExpSo3(tilt), place);
    case CalibrationMotion::kNoRotation:
      return MakePose(Eigen::Quaterniond::Identity(), place);
    case CalibrationMotion::kConstantHeight:
      break;
  }
  return MakePose(ExpSo3(heading), {place.x(), place.y(), 1.3});
}

Eigen::VectorXd Errors(const CalibrationState& state, const CalibrationFlightOptions& options,
                       ErrorDraw* draw) {
  const CalibrationLayout layout = LayoutOf(state);
  Eigen::VectorXd out = Eigen::VectorXd::Zero(layout.size());
  for (int i = 0; i < layout.n_tags; ++i) {
    out.segment<3>(layout.tag(i)) = draw->Normal3(options.tag_rotation_sigma_rad);
    out.segment<3>(layout.tag(i) + 3) = draw->Normal3(options.tag_position_sigma_m);
    const double side_m = state.tags[static_cast<size_t>(i)].size_m;
    if (options.tag_bend_sigma > 0) {
      out(layout.bend(i)) = draw->Normal3(options.tag_bend_sigma * side_m).x();
    }
  }
  if (!options.errors) return out;
  out(kLogFocal) = 0.01;
  out.segment<2>(kCentreX) << 1.92, -1.44;          // 2.4 px
  out.segment<2>(kFirstDistortion) << -0.03, 0.01;  // k1, k2
  out(layout.scale()) = 0.005;
  out.segment<3>(layout.mount()) << 0.0145, -0.0087, 0.0042;  // 1 deg
  out.segment<3>(layout.mount() + 3) << 0.006, -0.008, 0.0;   // 10 mm
  out(layout.clock()) = -0.015;
  return out;
}

// Pixel of a corner whose row is taken while the body moves on; `body_after`: seconds after the
// stamp.
template <typename BodyAfter>
std::optional<Eigen::Vector2d> SeeCorner(const CalibrationState& state,
                                         const Eigen::Vector3d& corner,
                                         const BodyAfter& body_after) {
  Eigen::Vector2d pixel(0, 0);
  const int rounds = state.line_time_s == 0 ? 1 : 8;  // until the row agrees with its time
  for (int i = 0; i < rounds; ++i) {
    const Pose cam_from_world =
        state.cam_from_body * Inverse(body_after(state.line_time_s * pixel.y()));
    const Eigen::Vector3d in_cam = cam_from_world * corner;
    // Beyond the field of view the lens model folds back.
    if (!(in_cam.z() > 0.1) || in_cam.head<2>().norm() > 1.2 * in_cam.z()) return std::nullopt;
    if (!state.camera.Project(in_cam, &pixel)) return std::nullopt;
  }
  return pixel;
}

template <typename BodyAfter>
std::optional<TagDetection> See(const CalibrationState& state, const Tag& tag,
                                const BodyAfter& body_after, double sigma_px, ErrorDraw* draw) {
  const std::array<Eigen::Vector3d, 4> corners = TagCornersInWorld(tag);
  TagDetection out;
  out.id = tag.id;
  for (size_t c = 0; c < 4; ++c) {
    const auto pixel = SeeCorner(state, std::exp(state.log_scale) * corners[c], body_after);
    if (!pixel) return std::nullopt;
    out.corners[c] = *pixel;
    if (!state.camera.Contains(out.corners[c], 2)) return std::nullopt;
    out.corners[c] += draw->Normal2(sigma_px);
  }
  return out;
}

}  // namespace

CalibrationFlight DrawCalibrationFlight(const CalibrationFlightOptions& options) {
  constexpr double kTruthStepS = 0.005, kStartS = 1;
  ErrorDraw draw(options.random_seed);
  CalibrationFlight out;
  out.config = DefaultConfig();
  out.config.set_up.map = Mat(options);
  out.config.calibration.tag_position_sigma_m = options.tag_position_sigma_m;
  out.config.calibration.tag_rotation_sigma_rad = options.tag_rotation_sigma_rad;
  out.config.calibration.tag_bend_sigma = options.tag_bend_sigma;
  CalibrationState believed;
  believed.camera = out.config.set_up.rig.front().camera;
  believed.cam_from_body = out.config.set_up.rig.front().cam_from_body;
  believed.tags = out.config.set_up.map.tags();
  out.truth = Retract(believed, Errors(believed, options, &draw));
  out.truth.line_time_s = options.line_time_s;
  for (int i = 0; i < options.frames; ++i) {
    const double t = kStartS + i / options.rate_hz;
    FrameMeasurements frame;
    frame.t_ns = std::llround(1e9 * t);
    const auto body_after = [&](double after_s) {
      return WorldFromBodyAt(t + out.truth.time_offset_s + after_s, options);
    };
    out.world_from_body.push_back(body_after(0));
    for (const Tag& tag : out.truth.tags) {
      if (const auto seen = See(out.truth, tag, body_after, options.corner_sigma_px, &draw)) {
        frame.tags.push_back(*seen);
      }
    }
    out.measurements.push_back(frame);
  }
  for (double t = 0; t < kStartS + options.frames / options.rate_hz + 1; t += kTruthStepS) {
    const Pose body = WorldFromBodyAt(t, options);
    TruthSample sample;
    sample.t_ns = std::llround(1e9 * t);
    const Eigen::Vector3d off = draw.Normal3(options.truth_position_sigma_m);
    const Eigen::Vector3d turn = draw.Normal3(options.truth_rotation_sigma_rad);
    sample.world_from_body = MakePose(body.rotation() * ExpSo3(turn), body.translation() + off);
    out.ground_truth.push_back(sample);
  }
  return out;
}

}  // namespace tagtwist::internal
