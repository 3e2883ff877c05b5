// Batch and window over recordings of up to a hundred frames, told by few bytes: stretches of rest,
// drift, vibration and slips, with tags that come, go and are wrong. What is learned from many
// frames, as the motion's densities, the lasting errors and motion that is not followed are, has
// them here; a dozen frames (fuzz_estimator.cc) do not reach it.
#include <algorithm>
#include <cmath>
#include <random>

#include "frontend/base/units.h"
#include "frontend/tags/filter_tags.h"
#include "tests/fuzz/fuzz_bytes.h"
#include "tests/fuzz/fuzz_estimating.h"
#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {
namespace {

using Draw = std::minstd_rand;  // the same numbers with every library

/// In [-1, 1].
double Signed(Draw* draw) {
  return 2 * static_cast<double>((*draw)() - Draw::min()) / (Draw::max() - Draw::min()) - 1;
}

/// Frames that have the same of everything.
struct Stretch {
  size_t frames = 1;
  int64_t period_ns = 0;
  double jitter = 0;                   // of the period
  PoseStep velocity, vibration, slip;  // rad/s and m/s; rad and m, of one frame
  double vibrations_a_frame = 0;
  size_t first_tag = 0, tags = 0;
  double noise_px = 0, outlier_px = 0;
  bool repeats = false, cut_short = false, has_covariance = false;
};

PoseStep TakeSize(FuzzBytes* in, double low_exponent, double high_exponent) {
  PoseStep out = PoseStep::Zero();
  const size_t kind = in->Below(4);
  if (kind == 0) return out;
  const double size = std::pow(10, in->Between(low_exponent, high_exponent));
  for (int i = 0; i < 6; ++i) {
    const bool is_turn = i < 3;
    if (kind == 1 && is_turn) continue;
    if (kind == 2 && !is_turn) continue;
    out(i) = size * in->Between(-1, 1);
  }
  return out;
}

Stretch TakeStretch(FuzzBytes* in) {
  Stretch out;
  out.frames = 1 + in->Below(48);
  out.period_ns = in->Below(4) != 0 ? 20'408'163 : std::llround(std::pow(10, in->Between(3, 9)));
  out.jitter = in->Below(4) != 0 ? 0 : in->Between(0, 1);
  out.velocity = TakeSize(in, -4, 1);
  out.vibration = TakeSize(in, -6, -1);
  out.slip = TakeSize(in, -6, -1);
  out.vibrations_a_frame = in->Between(0, 1);
  out.first_tag = in->Take<uint8_t>();
  out.tags = in->Below(4);
  out.noise_px = std::pow(10, in->Between(-3, 1));
  out.outlier_px = in->Below(4) != 0 ? 0 : std::pow(10, in->Between(-1, 2.5));
  const auto flags = in->Take<uint8_t>();
  out.repeats = flags % 32 == 1;
  out.cut_short = flags % 16 == 2;
  out.has_covariance = flags % 8 == 3;
  return out;
}

/// Tags in the image, with noise, in the map's order.
std::vector<TagDetection> InView(const Pose& world_from_body, double noise_px, Draw* draw) {
  const SetUp& set_up = CourseSetUpOnce();
  const RigCamera& seen_by = set_up.rig.front();
  const Pose cam_from_world = seen_by.cam_from_body * Inverse(world_from_body);
  std::vector<TagDetection> out;
  for (const Tag& tag : set_up.map.tags()) {
    TagDetection detection;
    detection.id = tag.id;
    const auto corners = TagCornersInWorld(tag);
    for (size_t k = 0; k < 4; ++k) {
      Eigen::Vector2d& pixel = detection.corners[k];
      if (!seen_by.camera.Project(cam_from_world * corners[k], &pixel)) pixel.setConstant(-1);
      for (double& coordinate : pixel) coordinate += noise_px * 1.7 * Signed(draw);
    }
    out.push_back(std::move(detection));
  }
  return FilterTags(out, set_up.map, seen_by.camera, 0);
}

/// A body that goes on from stretch to stretch.
class Flight {
 public:
  Flight(FuzzBytes* in, uint32_t seed) : in_(in), draw_(seed) {}

  void Add(const Stretch& stretch, size_t most) {
    for (size_t k = 0; k < stretch.frames && frames_.size() < most; ++k) AddFrame(stretch, k);
  }
  std::vector<FrameMeasurements> Frames() && { return std::move(frames_); }

 private:
  void AddFrame(const Stretch& stretch, size_t k) {
    const double period = 1 + stretch.jitter * 0.9 * Signed(&draw_);
    const int64_t step_ns =
        std::max<int64_t>(1, std::llround(period * static_cast<double>(stretch.period_ns)));
    FrameMeasurements out;
    out.t_ns = frames_.empty() ? 1'000'000'000 : frames_.back().t_ns + step_ns;
    at_ += std::min(1e-9 * static_cast<double>(step_ns), 1.0) * stretch.velocity;
    for (double& value : slipped_) value *= 0.8;
    for (int i = 0; i < 6; ++i) slipped_(i) += stretch.slip(i) * Signed(&draw_);
    const double phase = 2 * kPi * stretch.vibrations_a_frame * static_cast<double>(k);
    const PoseStep step = at_ + slipped_ + std::sin(phase) * stretch.vibration;
    const Eigen::Vector3d turn = step.head<3>();
    const Eigen::Vector3d axis = turn.norm() > 0 ? turn.normalized() : Eigen::Vector3d::UnitX();
    out.tags = Tags(stretch, MakePose(Eigen::Quaterniond(Eigen::AngleAxisd(turn.norm(), axis)),
                                      Eigen::Vector3d(1.5, 1.3, 1.2) + step.tail<3>()));
    out.cut_short = stretch.cut_short;
    if (stretch.repeats && !frames_.empty()) out.tags = frames_.back().tags;
    frames_.push_back(std::move(out));
  }

  std::vector<TagDetection> Tags(const Stretch& stretch, const Pose& world_from_body) {
    const std::vector<TagDetection> in_view = InView(world_from_body, stretch.noise_px, &draw_);
    std::vector<TagDetection> out;
    for (size_t k = 0; k < std::min(stretch.tags, in_view.size()); ++k) {
      out.push_back(in_view[(stretch.first_tag + k) % in_view.size()]);
      if (stretch.has_covariance) out.back().covariance = TakeCovariance(in_);
    }
    if (!out.empty()) {
      for (auto& corner : out.back().corners) corner.x() += stretch.outlier_px;
    }
    return out;
  }

  FuzzBytes* in_;
  Draw draw_;
  PoseStep at_ = PoseStep::Zero(), slipped_ = PoseStep::Zero();
  std::vector<FrameMeasurements> frames_;
};

std::vector<FrameMeasurements> TakeFlight(FuzzBytes* in) {
  const size_t most = 24 + in->Below(72);
  Flight flight(in, 1 + in->Take<uint16_t>());
  size_t frames = 0;
  for (size_t n = 0; n < 12 && frames < most; ++n) {
    const Stretch stretch = TakeStretch(in);
    flight.Add(stretch, most);
    frames += stretch.frames;
  }
  return std::move(flight).Frames();
}

/// The bytes that TakeStretch reads as a stretch of so many frames at 49 Hz, whose motions have
/// these sizes (1e-6 to 0.1 rad and m a frame; 0: none).
std::string StretchBytes(size_t frames, double vibration, double slip, size_t tags) {
  std::string out;
  const auto byte = [&](size_t value) { out += static_cast<char>(value); };
  const auto fraction = [&](double value) {
    const auto number = static_cast<uint16_t>(std::lround(value * 65535));
    out.append(reinterpret_cast<const char*>(&number), sizeof(number));
  };
  const auto size = [&](double value) {
    byte(value > 0 ? 3 : 0);
    if (value == 0) return;
    fraction((std::log10(value) + 6) / 5);
    for (int i = 0; i < 6; ++i) fraction(i % 2 == 0 ? 1 : 0);
  };
  byte(frames - 1);
  byte(1), byte(1);  // its period, and no jitter
  byte(0);           // at rest
  size(vibration), size(slip);
  fraction(0.37);
  byte(28), byte(tags);
  fraction(0.6);     // 0.25 px
  byte(1), byte(0);  // no outlier
  return out;
}

}  // namespace

bool FuzzFlight(const std::string& bytes) {
  FuzzBytes in(bytes);
  EstimatorOptions options;
  if (in.Below(4) == 1) options = TakeOptions(&in);
  if (options.Problem()) return false;
  return EstimatesSoundly(options, TakeFlight(&in));
}

std::vector<FuzzSeed> FlightSeeds() {
  std::vector<FuzzSeed> out;
  const std::string begin("\0\x22\x07\x00", 4);  // options that nobody gave, 58 frames
  const auto add = [&](const std::string& name, const std::string& bytes) {
    if (FuzzFlight(bytes)) out.push_back({name, bytes});
  };
  add("vibration", begin + StretchBytes(40, 1e-3, 0, 3) + StretchBytes(48, 1e-3, 0, 2));
  add("slips", begin + StretchBytes(40, 0, 1e-3, 3) + StretchBytes(48, 0, 3e-4, 3));
  add("gap", begin + StretchBytes(30, 0, 1e-4, 3) + StretchBytes(9, 0, 0, 0) +
                 StretchBytes(48, 1e-2, 0, 1));
  Draw draw(3);
  std::string anything;
  for (int i = 0; i < 200; ++i) anything += static_cast<char>(draw() >> 8);
  add("anything", anything);
  return out;
}

}  // namespace tagtwist::internal
