#include "tests/exact_model.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "estimator/config.h"
#include "frontend/types/so3.h"

namespace tagtwist {
namespace {

class Draw {
 public:
  explicit Draw(unsigned seed) : rng_(seed) {}
  Eigen::Vector3d Normal3() { return {normal_(rng_), normal_(rng_), normal_(rng_)}; }
  Eigen::Vector2d Normal2() { return {normal_(rng_), normal_(rng_)}; }

 private:
  std::mt19937_64 rng_;
  std::normal_distribution<double> normal_;
};

// One step of the motion model: the errors of an axis pair have covariance psd
// [dt^3/3, dt^2/2; dt^2/2, dt].
BodyState Step(const BodyState& state, double dt_s, const ExactModelOptions& options, Draw* draw) {
  Eigen::Matrix2d q;
  q << dt_s * dt_s * dt_s / 3, dt_s * dt_s / 2, dt_s * dt_s / 2, dt_s;
  const Eigen::Matrix2d root = q.llt().matrixL();
  const auto pair = [&](double psd) {
    const Eigen::Vector3d a = draw->Normal3(), b = draw->Normal3();
    const double s = std::sqrt(psd);
    return std::make_pair(Eigen::Vector3d(s * root(0, 0) * a),
                          Eigen::Vector3d(s * (root(1, 0) * a + root(1, 1) * b)));
  };
  const auto [e_p, e_v] = pair(options.accel_psd);
  const auto [e_theta, e_omega] = pair(options.angular_accel_psd);
  const Eigen::Vector3d phi = dt_s * state.twist.omega_body + e_theta;
  BodyState next;
  next.world_from_body =
      MakePose(state.world_from_body.rotation() * ExpSo3(phi),
               state.world_from_body.translation() + dt_s * state.twist.v_world + e_p);
  next.twist.v_world = state.twist.v_world + e_v;
  next.twist.omega_body = RightJacobianSo3(phi) * (state.twist.omega_body + e_omega);
  return next;
}

std::vector<TagDetection> SeeTags(const EstimatorSetup& setup, const BodyState& state,
                                  const ExactModelOptions& options, Draw* draw) {
  std::vector<TagDetection> tags;
  const Pose cam_from_world = setup.cam_from_body * Inverse(state.world_from_body);
  for (const Tag& tag : setup.map.tags()) {
    if (static_cast<int>(tags.size()) == options.max_tags) break;
    TagDetection seen;
    seen.id = tag.id;
    bool visible = true;
    for (size_t c = 0; c < 4; ++c) {
      visible = visible &&
                setup.camera.Project(cam_from_world * setup.map.CornersInWorld(tag.id)[c],
                                     &seen.corners[c]) &&
                setup.camera.Contains(seen.corners[c], 2);
    }
    if (!visible) continue;
    for (auto& corner : seen.corners) corner += options.corner_sigma_px * draw->Normal2();
    tags.push_back(seen);
  }
  return tags;
}

}  // namespace

EstimatorSetup CourseSetup(const EstimatorOptions& options) {
  const Config config = DefaultConfig();
  return MakeEstimatorSetup(config.camera, config.cam_from_body, config.map, options);
}

ExactModelFlight DrawFlight(const ExactModelOptions& options) {
  const EstimatorSetup setup = CourseSetup();
  Draw draw(options.seed);
  BodyState state;
  state.world_from_body = MakePose(ExpSo3(0.1 * draw.Normal3()), {1.6, 1.3, 1.3});
  state.twist = {0.3 * draw.Normal3(), 0.2 * draw.Normal3()};
  ExactModelFlight flight;
  const double dt_s = 1 / options.rate_hz;
  for (int i = 0; i < options.frames; ++i) {
    if (i > 0) state = Step(state, dt_s, options, &draw);
    FrameMeasurements m;
    m.t_ns = static_cast<int64_t>(std::llround(1e9 * dt_s * i));
    m.tags = SeeTags(setup, state, options, &draw);
    flight.truth.push_back(state);
    flight.measurements.push_back(std::move(m));
  }
  return flight;
}

}  // namespace tagtwist
