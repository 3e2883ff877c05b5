#include <gflags/gflags.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <string>
#include <vector>

#include "bench/run_bench.h"
#include "frontend/base/option_check.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/base/statistics/random_stream.h"
#include "frontend/front_end.h"
#include "frontend/geometry/frame_pose.h"
#include "frontend/simulation/renderer.h"
#include "frontend/tags/find_tags.h"

DEFINE_int32(pictures, 20, "Of each row.");
DEFINE_uint64(seed, 1, "Of everything random.");
DEFINE_string(family, "tag36h11b2", "Of the tags.");

namespace tagtwist::internal {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr uint64_t kViewPurpose = 0x7374;  // of the random stream

struct Row {
  const char* name;
  Camera camera;
  RendererOptions look;
  double nearest_m = 0.4, farthest_m = 1.2, tilt_rad = 1.0;
};

Camera Radtan() {
  Camera out;
  out.width = 640, out.height = 480, out.fx = 380, out.fy = 381, out.cx = 322, out.cy = 236;
  out.k1 = -0.28, out.k2 = 0.07, out.p1 = 2e-4, out.p2 = -3e-4;
  return out;
}

Camera Fisheye() {
  Camera out;
  out.width = 640, out.height = 480, out.fx = 290, out.fy = 290.5, out.cx = 318, out.cy = 243;
  out.lens = LensModel::kEquidistant;
  out.k1 = -0.01, out.k2 = 0.03, out.p1 = -0.02, out.p2 = 0.005;
  return out;
}

std::vector<Row> Rows() {
  RendererOptions good;
  good.supersampling = 3;
  good.scene.scribbles_per_m2 = 0;
  RendererOptions dim = good;
  dim.scene.paper_grey = dim.scene.floor_grey = 120, dim.scene.ink_grey = 45;
  dim.gradient = 0.8, dim.vignetting = 0.5, dim.noise_grey = 4;
  RendererOptions blurred = good;
  blurred.blur_px = 1.4, blurred.noise_grey = 4;
  return {{"radtan", Radtan(), good},     {"radtan, far", Radtan(), good, 1.2, 2.5, 0.8},
          {"radtan, dim", Radtan(), dim}, {"radtan, blurred", Radtan(), blurred},
          {"fisheye", Fisheye(), good},   {"fisheye, dim", Fisheye(), dim}};
}

// 6 x 6 tags of 88 mm, 30 % of that apart; tag 0 at the bottom left, as Kalibr counts.
TagMap Board() {
  std::vector<Tag> tags;
  for (int i = 0; i < 36; ++i) {
    const Eigen::Vector3d centre(0.044 + 0.1144 * (i % 6), 0.044 + 0.1144 * (i / 6), 0);
    tags.push_back({i, MakePose(Eigen::Quaterniond::Identity(), centre), 0.088});
  }
  return TagMap(FLAGS_family, tags);
}

// Looks at a point on the board or a little beside it, tilted and turned anyhow.
Pose DrawView(const Row& row, RandomStream* random) {
  const double y = random->Uniform(-0.05, 0.7), x = random->Uniform(-0.05, 0.7);
  const Eigen::Vector3d target(x, y, 0);
  const double distance_m =
      row.nearest_m * std::pow(row.farthest_m / row.nearest_m, random->Uniform(0, 1));
  const double heading = random->Uniform(-kPi, kPi), tilt = random->Uniform(0, row.tilt_rad);
  const Eigen::Quaterniond world_from_cam =
      Eigen::AngleAxisd(heading, Eigen::Vector3d::UnitZ()) *
      Eigen::AngleAxisd(kPi + tilt, Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(random->Uniform(-kPi, kPi), Eigen::Vector3d::UnitZ());
  return MakePose(world_from_cam,
                  target - distance_m * (world_from_cam * Eigen::Vector3d::UnitZ()));
}

using Corners = std::array<Eigen::Vector2d, 4>;

// Whole in the image, by id.
std::map<int, Corners> VisibleTags(const TagMap& map, const Camera& camera,
                                   const Pose& cam_from_world) {
  constexpr double kBorderPx = 3;
  std::map<int, Corners> out;
  for (const Tag& tag : map.tags()) {
    Corners corners;
    bool in = true;
    for (size_t c = 0; c < 4 && in; ++c) {
      in = camera.Project(cam_from_world * map.CornersInWorld(tag.id)[c], &corners[c]) &&
           camera.Contains(corners[c], kBorderPx);
    }
    if (in) out.emplace(tag.id, corners);
  }
  return out;
}

struct Score {
  int seen = 0, found = 0, wrong = 0, without_pose = 0;  // wrong: a corner is off by more than 1 px
  std::vector<double> corner_px, offset_mm, turn_deg;    // corner_px: of a tag the worst
};

void AddPicture(const TagMap& map, const Camera& camera, const Pose& world_from_cam,
                const std::vector<TagDetection>& tags, Score* score) {
  const auto visible = VisibleTags(map, camera, Inverse(world_from_cam));
  score->seen += static_cast<int>(visible.size());
  for (const TagDetection& tag : tags) {
    const auto truth = visible.find(tag.id);
    if (truth == visible.end()) continue;  // at the very border
    ++score->found;
    double worst_px = 0;
    for (size_t c = 0; c < 4; ++c) {
      worst_px = std::max(worst_px, (tag.corners[c] - truth->second[c]).norm());
    }
    score->wrong += worst_px > 1 ? 1 : 0;
    score->corner_px.push_back(worst_px);
  }
  const FramePose found = FindFramePose(tags, map, camera, Pose());
  if (found.status != FramePoseStatus::kOk) {
    ++score->without_pose;
    return;
  }
  const Pose off = Inverse(world_from_cam) * found.world_from_body;
  score->offset_mm.push_back(1e3 * off.translation().norm());
  score->turn_deg.push_back(AngleBetween(Pose(), off) * 180 / kPi);
}

double QuantileOf(const std::vector<double>& values, double share) {
  return values.empty() ? NAN : Quantile(values, share);
}

Status MeasureRow(const Row& row, uint64_t index) {
  constexpr size_t kLeastTags = 4;
  const TagMap map = Board();
  const auto renderer = Renderer::Make(row.camera, map, row.look);
  if (!renderer) return renderer.error();
  const auto detector = TagDetector::Create(map.family(), {});
  if (!detector) return detector.error();
  const auto refiner = CornerRefiner::Create(map, row.camera);
  if (!refiner) return refiner.error();
  Score score;
  RandomStream random(FLAGS_seed, kViewPurpose, index);
  for (int picture = 0; picture < FLAGS_pictures;) {
    const Pose world_from_cam = DrawView(row, &random);
    if (VisibleTags(map, row.camera, Inverse(world_from_cam)).size() < kLeastTags) continue;
    const auto number = static_cast<uint64_t>(picture++);
    const cv::Mat image = renderer->Render({world_from_cam}, 0, number);
    const auto tags = FindTags(image, *detector, *refiner, map, row.camera, {});
    AddPicture(map, row.camera, world_from_cam, tags, &score);
  }
  std::printf("%-16s %5d %6.1f%% %6d %8d %10.3f %8.3f %8.3f %8.2f %8.2f %8.3f\n", row.name,
              score.seen, 100.0 * score.found / score.seen, score.wrong, score.without_pose,
              QuantileOf(score.corner_px, 0.5), QuantileOf(score.corner_px, 0.95),
              QuantileOf(score.corner_px, 1), QuantileOf(score.offset_mm, 0.5),
              QuantileOf(score.offset_mm, 1), QuantileOf(score.turn_deg, 1));
  return Ok();
}

Status Measure() {
  std::printf("%-16s %5s %7s %6s %8s %10s %8s %8s %8s %8s %8s\n", "", "seen", "found", "wrong",
              "no pose", "corner px", "p95", "max", "pose mm", "max", "max deg");
  const std::vector<Row> rows = Rows();
  for (size_t i = 0; i < rows.size(); ++i) {
    if (const auto measured = MeasureRow(rows[i], i); !measured) return measured;
  }
  return Ok();
}

Usage StillsUsage() {
  return {
      "stills",
      "[--family NAME] [--pictures N] [...]",
      "Single pictures of a board of 6 x 6 tags, Kalibr's aprilgrid unless --family says other:\n"
      "how many of the tags that are whole in the image are found, how far their worst corners\n"
      "are off, and the pose that they give. No picture knows of another.",
      {{"The pictures", {"family", "pictures", "seed"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem({CheckRange("pictures", FLAGS_pictures, 1, 1e5)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::RunBench(argc, argv, tagtwist::internal::StillsUsage(),
                                      tagtwist::internal::FlagProblem, tagtwist::internal::Measure);
}
