#include "frontend/simulation/simulator.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <set>
#include <utility>

#include "frontend/base/number_text.h"
#include "frontend/base/option_check.h"
#include "frontend/base/statistics/random_stream.h"
#include "frontend/simulation/renderer.h"
#include "frontend/types/lens/lens.h"

namespace tagtwist {

using namespace internal;
namespace {

constexpr uint64_t kDetectionPurpose = 4, kImuPurpose = 5, kStampPurpose = 6,
                   kBiasPurpose = 7;  // random streams
constexpr double kGravityMps2 = 9.81;
constexpr double kBlurStepPx = 0.25;  // image motion from one sub-frame of an exposure to the next
constexpr int kMostSubFrames = 32;

// True when a patch hides a part of the paper, tried at 7 x 7 points.
bool HidesPart(const Patch& patch, const Eigen::Vector3d& camera_in_world, const Patch& paper) {
  for (int i = -3; i <= 3; ++i) {
    for (int j = -3; j <= 3; ++j) {
      const Eigen::Vector3d point = paper.centre + i / 3.0 * paper.half_u + j / 3.0 * paper.half_v;
      if (Hides(patch, camera_in_world, point)) return true;
    }
  }
  return false;
}

double ShortestSide(const TagDetection& tag) {
  double shortest = std::numeric_limits<double>::infinity();
  for (size_t c = 0; c < 4; ++c) {
    shortest = std::min(shortest, (tag.corners[c] - tag.corners[(c + 1) % 4]).norm());
  }
  return shortest;
}

// Where a corner is seen, its row taken while the camera moves on. `cam_from_world_after`: so many
// seconds after the stamp.
template <typename CamFromWorldAfter>
std::optional<Eigen::Vector2d> ProjectCorner(const Camera& camera, double line_time_s,
                                             const Eigen::Vector3d& corner_in_world,
                                             const CamFromWorldAfter& cam_from_world_after) {
  constexpr int kMostRounds = 20;
  constexpr double kEnoughPx = 1e-9;
  Eigen::Vector2d pixel(0, 0);
  for (int i = 0; i < kMostRounds; ++i) {
    const double row = pixel.y();
    const Eigen::Vector3d in_cam = cam_from_world_after(line_time_s * row) * corner_in_world;
    if (!camera.Project(in_cam, &pixel)) return std::nullopt;
    const auto ray = camera.Unproject(pixel);  // past a fold it is another one
    if (!ray || !((*ray - in_cam.hnormalized()).norm() < 1e-6)) return std::nullopt;
    if (line_time_s == 0 || std::abs(pixel.y() - row) < kEnoughPx) break;
  }
  if (!camera.Contains(pixel)) return std::nullopt;
  return pixel;
}

// The tag's true corners, or nullopt where it cannot be seen whole and from its front.
template <typename CamFromWorldAfter>
std::optional<TagDetection> ProjectTag(const Camera& camera, double line_time_s, const Tag& tag,
                                       const std::array<Eigen::Vector3d, 4>& corners_in_world,
                                       const CamFromWorldAfter& cam_from_world_after) {
  const Pose cam_from_tag = cam_from_world_after(0.0) * tag.world_from_tag;
  const Eigen::Vector3d normal = cam_from_tag.rotation() * Eigen::Vector3d::UnitZ();
  if (!(normal.dot(cam_from_tag.translation()) < 0)) return std::nullopt;
  TagDetection out;
  out.id = tag.id;
  for (size_t c = 0; c < 4; ++c) {
    const auto pixel =
        ProjectCorner(camera, line_time_s, corners_in_world[c], cam_from_world_after);
    if (!pixel) return std::nullopt;
    out.corners[c] = *pixel;
  }
  return out;
}

}  // namespace

std::optional<std::string> SimulatorOptions::Problem() const {
  const double inf = std::numeric_limits<double>::infinity();
  for (const auto& problem : {renderer.Problem(), CheckRange("exposure_s", exposure_s, 0, 1),
                              CheckRange("line_time_s", line_time_s, -1e-3, 1e-3),
                              CheckRange("corner_noise_px", corner_noise_px, 0, 100),
                              CheckRange("min_tag_side_px", min_tag_side_px, 0, inf),
                              CheckRange("hidden_fraction", hidden_fraction, 0, 1),
                              CheckRange("wrong_id_fraction", wrong_id_fraction, 0, 1),
                              CheckRange("hide_tags_from_s", hide_tags_from_s, -inf, inf),
                              CheckRange("hide_tags_to_s", hide_tags_to_s, -inf, inf),
                              CheckRange("imu_rate_hz", imu_rate_hz, 0, 1e5),
                              CheckRange("gyro_noise_radps", gyro_noise_radps, 0, inf),
                              CheckRange("accel_noise_mps2", accel_noise_mps2, 0, inf),
                              CheckRange("gyro_bias_radps", gyro_bias_radps, 0, inf),
                              CheckRange("accel_bias_mps2", accel_bias_mps2, 0, inf)}) {
    if (problem) return problem;
  }
  if (images && line_time_s != 0)
    return "line_time_s: expected 0 with images, got " + FormatNumber(line_time_s);
  return std::nullopt;
}

struct Simulator::Impl {
  Renderer renderer;
};

Result<Simulator> Simulator::Make(const SetUp& set_up, const SplineTrajectory& trajectory,
                                  const SimulatorOptions& options) {
  if (const auto problem = options.Problem()) return Error{*problem};
  for (const Tag& tag : set_up.map.tags()) {
    if (!options.images || tag.bend_m == 0) continue;
    return Error{"tag " + std::to_string(tag.id) +
                 ": bend_m: expected 0 with images, which are drawn of plane tags"};
  }
  RendererOptions look = options.renderer;
  look.scene.random_seed = options.random_seed;
  auto renderer = Renderer::Make(set_up.rig.front().camera, set_up.map, look);
  if (!renderer) return renderer.error();
  return Simulator(std::make_shared<const Impl>(Impl{std::move(*renderer)}), set_up, trajectory,
                   options);
}

Simulator::Simulator(std::shared_ptr<const Impl> impl, const SetUp& set_up,
                     const SplineTrajectory& trajectory, const SimulatorOptions& options)
    : impl_(std::move(impl)),
      cam_from_body_(set_up.rig.front().cam_from_body),
      mounted_on_(set_up.rig.mounted_on),
      map_(set_up.map),
      trajectory_(trajectory),
      options_(options) {}

Pose Simulator::WorldFromCam(int64_t t_ns) const {
  const Pose world_from_body = trajectory_.At(t_ns).world_from_body;
  return mounted_on_ == MountedOn::kBody ? world_from_body * Inverse(cam_from_body_)
                                         : Inverse(cam_from_body_ * world_from_body);
}

bool Simulator::TagsAreHiddenAt(int64_t t_ns) const {
  const double t_s = ToSeconds(t_ns);
  return t_s >= options_.hide_tags_from_s && t_s < options_.hide_tags_to_s;
}

// As many sub-frames as the motion of the nearest tag in the image asks for.
std::vector<Pose> Simulator::ExposurePoses(int64_t t_ns) const {
  const double exposure_ns = 1e9 * options_.exposure_s;
  const auto at = [&](double share) {  // -1/2 .. 1/2 of the exposure
    return WorldFromCam(t_ns + std::llround(share * exposure_ns));
  };
  const Pose begin = at(-0.5), end = at(0.5);
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const Tag& tag : map_.tags()) {
    nearest_m = std::min(nearest_m, (Inverse(begin) * tag.world_from_tag.translation()).norm());
  }
  const double turn = begin.rotation().angularDistance(end.rotation());
  const double shift = (end.translation() - begin.translation()).norm() / nearest_m;
  const double motion_px = FocalLengthOnAxis(impl_->renderer.camera()) * (turn + shift);
  const int count =
      static_cast<int>(std::clamp(std::ceil(motion_px / kBlurStepPx), 1.0, 1.0 * kMostSubFrames));
  std::vector<Pose> out;
  out.reserve(static_cast<size_t>(count));
  for (int k = 0; k < count; ++k) out.push_back(at((k + 0.5) / count - 0.5));
  return out;
}

std::vector<TagDetection> Simulator::FindVisibleTags(int64_t t_ns) const {
  std::vector<TagDetection> out;
  if (TagsAreHiddenAt(t_ns)) return out;
  const Pose world_from_cam = WorldFromCam(t_ns), cam_from_world = Inverse(world_from_cam);
  const Eigen::Vector3d camera_in_world = world_from_cam.translation();
  const auto cam_from_world_after = [&](double after_s) {
    if (after_s == 0) return cam_from_world;
    const int64_t at_ns = t_ns + std::llround(1e9 * after_s);
    return Inverse(WorldFromCam(std::clamp(at_ns, trajectory_.first_ns(), trajectory_.last_ns())));
  };
  const Scene& scene = impl_->renderer.scene();
  const std::vector<Patch> occluders = scene.OccludersAt(ToSeconds(t_ns));
  for (size_t i = 0; i < map_.tags().size(); ++i) {
    const Tag& tag = map_.tags()[i];
    const auto seen = ProjectTag(impl_->renderer.camera(), options_.line_time_s, tag,
                                 map_.CornersInWorld(tag.id), cam_from_world_after);
    if (!seen || ShortestSide(*seen) < options_.min_tag_side_px) continue;
    const Patch& paper = scene.tags()[i];
    const auto hides = [&](const Patch& patch) {
      return &patch != &paper && HidesPart(patch, camera_in_world, paper);
    };
    const bool hidden = std::any_of(occluders.begin(), occluders.end(), hides) ||
                        (!scene.all_tags_on_floor() &&
                         std::any_of(scene.tags().begin(), scene.tags().end(), hides)) ||
                        std::any_of(scene.walls().begin(), scene.walls().end(),
                                    [&](const WallSheet& wall) { return hides(wall.sheet); });
    if (!hidden) out.push_back(*seen);
  }
  return out;
}

void Simulator::Disturb(uint64_t index, std::vector<TagDetection>* detections) const {
  RandomStream random(options_.random_seed, kDetectionPurpose, index);
  std::set<int> used;
  for (const TagDetection& tag : *detections) used.insert(tag.id);
  std::vector<TagDetection> kept;
  for (TagDetection tag : *detections) {
    const bool missed = random.Uniform() < options_.hidden_fraction;
    const bool wrong = random.Uniform() < options_.wrong_id_fraction;
    for (Eigen::Vector2d& corner : tag.corners) {
      const double du = random.Normal(), dv = random.Normal();
      corner += options_.corner_noise_px * Eigen::Vector2d(du, dv);
    }
    const int other = map_.tags()[random.Below(map_.tags().size())].id;
    if (wrong && used.insert(other).second) tag.id = other;
    if (!missed) kept.push_back(tag);
  }
  *detections = std::move(kept);
}

SimulatedFrame Simulator::MakeFrame(uint64_t index, int64_t t_ns) const {
  SimulatedFrame out;
  out.t_ns = t_ns;
  out.truth = trajectory_.At(t_ns);
  out.detections = FindVisibleTags(t_ns);
  Disturb(index, &out.detections);
  if (options_.images) {
    out.image =
        impl_->renderer.Render(ExposurePoses(t_ns), ToSeconds(t_ns), index, TagsAreHiddenAt(t_ns));
  }
  return out;
}

std::vector<ImuSample> Simulator::MakeImu(int64_t first_ns, int64_t last_ns) const {
  std::vector<ImuSample> out;
  if (!(options_.imu_rate_hz > 0)) return out;
  const auto draw = [](double sigma, RandomStream* random) {
    const double x = random->Normal(), y = random->Normal(), z = random->Normal();
    return Eigen::Vector3d(sigma * x, sigma * y, sigma * z);
  };
  RandomStream of_biases(options_.random_seed, kBiasPurpose);
  const Eigen::Vector3d gyro_bias = draw(options_.gyro_bias_radps, &of_biases);
  const Eigen::Vector3d accel_bias = draw(options_.accel_bias_mps2, &of_biases);
  RandomStream random(options_.random_seed, kImuPurpose);
  const auto noise = [&](double sigma) { return draw(sigma, &random); };
  const double interval_ns = 1e9 / options_.imu_rate_hz;
  for (int64_t k = 0;; ++k) {
    ImuSample sample;
    sample.t_ns = first_ns + std::llround(interval_ns * static_cast<double>(k));
    if (sample.t_ns > last_ns) return out;
    const BodyState state = trajectory_.At(sample.t_ns);
    const Eigen::Vector3d force =
        trajectory_.AccelerationAt(sample.t_ns) + kGravityMps2 * Eigen::Vector3d::UnitZ();
    sample.gyro_radps = state.twist.omega_body + gyro_bias + noise(options_.gyro_noise_radps);
    sample.accel_mps2 = state.world_from_body.rotation().conjugate() * force + accel_bias +
                        noise(options_.accel_noise_mps2);
    out.push_back(sample);
  }
}

std::optional<std::string> StampOptions::Problem() const {
  if (auto problem = CheckRange("rate_hz", rate_hz, 0.01, 1e5)) return problem;
  return CheckRange("jitter_s", jitter_s, 0, 0.45 / rate_hz);
}

Result<std::vector<int64_t>> MakeStamps(int64_t first_ns, int64_t last_ns,
                                        const StampOptions& options) {
  if (const auto problem = options.Problem()) return Error{*problem};
  RandomStream random(options.random_seed, kStampPurpose);
  std::vector<int64_t> out;
  for (int64_t k = 0;; ++k) {
    const double raster_ns = 1e9 * static_cast<double>(k) / options.rate_hz;
    if (first_ns + std::llround(raster_ns) > last_ns) return out;
    const double jitter_ns = 1e9 * random.Uniform(-options.jitter_s, options.jitter_s);
    out.push_back(
        std::clamp<int64_t>(first_ns + std::llround(raster_ns + jitter_ns), first_ns, last_ns));
  }
}

}  // namespace tagtwist
