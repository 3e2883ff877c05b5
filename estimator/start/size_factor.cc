#include "estimator/start/size_factor.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/geometry/frame_pose.h"
#include "frontend/geometry/homography.h"
#include "frontend/geometry/pose_refine.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

std::vector<TagDetection> InMap(const std::vector<TagDetection>& tags, const TagMap& map) {
  std::vector<TagDetection> out;
  std::copy_if(tags.begin(), tags.end(), std::back_inserter(out),
               [&](const TagDetection& tag) { return map.Find(tag.id) != nullptr; });
  return out;
}

// The map of these tags, each scaled about its centre.
TagMap Scaled(const std::vector<TagDetection>& tags, const TagMap& map, double factor) {
  std::vector<Tag> scaled;
  for (const TagDetection& seen : tags) {
    scaled.push_back(*map.Find(seen.id));
    scaled.back().size_m *= factor;
    scaled.back().bend_m *= factor;
  }
  return TagMap(map.family(), std::move(scaled));
}

RefinedPose Refine(const Pose& cam_from_world, const std::vector<TagDetection>& tags,
                   const TagMap& map, const Camera& camera) {
  std::vector<PointInImage> points;
  for (const TagDetection& tag : tags) {
    const auto& corners_in_world = map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) points.push_back({corners_in_world[c], tag.corners[c]});
  }
  return RefinePose(cam_from_world, points, camera);
}

// A first guess: how far tags are from each other by the map, against how far by their own poses,
// which their sizes scale.
std::optional<double> FactorOfDistances(const std::vector<TagDetection>& tags, const TagMap& map,
                                        const Camera& camera) {
  constexpr size_t kMostTags = 5;
  std::vector<Eigen::Vector3d> in_cam, in_world;
  for (const TagDetection& tag : tags) {
    if (in_cam.size() == kMostTags) break;
    const Pose& world_from_tag = map.Find(tag.id)->world_from_tag;
    const auto world_from_cam = PoseFromTags({tag}, map, world_from_tag, camera, {});
    if (!world_from_cam) continue;
    const RefinedPose refined = Refine(Inverse(*world_from_cam), {tag}, map, camera);
    in_world.emplace_back(world_from_tag.translation());
    in_cam.push_back(refined.cam_from_world * in_world.back());
  }
  std::vector<double> factors;
  for (size_t i = 0; i < in_cam.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const double apart_m = (in_cam[i] - in_cam[j]).norm();
      if (apart_m > 0) factors.push_back((in_world[i] - in_world[j]).norm() / apart_m);
    }
  }
  if (factors.empty()) return std::nullopt;
  const double factor = Quantile(factors, 0.5);
  return factor > 0 && std::isfinite(factor) ? std::optional(factor) : std::nullopt;
}

// Least squares over the logarithm of the factor, by parabolas through three points, and the poses.
struct FactorFit {
  double log_factor = 0;
  RefinedPose pose;
};
FactorFit FitFrom(double log_factor, const Pose& cam_from_world,
                  const std::vector<TagDetection>& tags, const TagMap& map, const Camera& camera) {
  constexpr int kSteps = 6;
  double reach = 0.05;
  const auto at = [&](double log, const Pose& start) {
    return Refine(start, tags, Scaled(tags, map, std::exp(log)), camera);
  };
  FactorFit best{log_factor, at(log_factor, cam_from_world)};
  for (int step = 0; step < kSteps; ++step) {
    const Pose start = best.pose.cam_from_world;
    const double below = at(best.log_factor - reach, start).squared_error_px2;
    const double above = at(best.log_factor + reach, start).squared_error_px2;
    const double curve = above + below - 2 * best.pose.squared_error_px2;
    double move = curve > 0 ? 0.5 * reach * (below - above) / curve : below < above ? -0.1 : 0.1;
    move = std::clamp(move, -0.2, 0.2);
    if (!std::isfinite(move)) break;
    const FactorFit moved{best.log_factor + move, at(best.log_factor + move, start)};
    if (!(moved.pose.squared_error_px2 < best.pose.squared_error_px2)) break;
    best = moved;
    if (std::abs(move) < 1e-3) break;
    reach = std::clamp(std::abs(move), 0.005, 0.05);
  }
  return best;
}

// What the squares with the map as it is come to: from the pose that most of its tags agree on, or,
// where that is worse, from the pose with the factor.
double ErrorAsTold(const Pose& cam_from_world, const std::vector<TagDetection>& tags,
                   const TagMap& map, const Camera& camera) {
  const double error = Refine(cam_from_world, tags, map, camera).squared_error_px2;
  const FramePose found = FindFramePose(tags, map, camera, Pose());
  if (found.status != FramePoseStatus::kOk) return error;
  return std::min(error,
                  Refine(Inverse(found.world_from_body), tags, map, camera).squared_error_px2);
}

}  // namespace

std::optional<SizeFactor> FitSizeFactor(const std::vector<TagDetection>& all_tags,
                                        const TagMap& map, const Camera& camera) {
  const std::vector<TagDetection> tags = InMap(all_tags, map);
  if (tags.size() < 2) return std::nullopt;
  const auto guess = FactorOfDistances(tags, map, camera);
  if (!guess) return std::nullopt;
  std::optional<FactorFit> best;
  for (const double start : {1.0, *guess}) {
    const FramePose found = FindFramePose(tags, Scaled(tags, map, start), camera, Pose());
    if (found.status != FramePoseStatus::kOk) continue;
    const FactorFit fit =
        FitFrom(std::log(start), Inverse(found.world_from_body), tags, map, camera);
    if (!best || fit.pose.squared_error_px2 < best->pose.squared_error_px2) best = fit;
  }
  if (!best || !std::isfinite(best->pose.squared_error_px2)) return std::nullopt;
  const double factor = std::exp(best->log_factor);
  const FramePose with_factor = FindFramePose(tags, Scaled(tags, map, factor), camera, Pose());
  if (std::count(with_factor.tag_inlier.begin(), with_factor.tag_inlier.end(), false) > 0) {
    return std::nullopt;
  }
  return SizeFactor{factor, best->pose.squared_error_px2,
                    ErrorAsTold(best->pose.cam_from_world, tags, map, camera)};
}

std::optional<double> CommonSizeFactor(const std::vector<std::optional<SizeFactor>>& frames) {
  constexpr double kNear = 0.05, kLeast = 0.06, kLeftOfErrors = 0.25, kShare = 0.7;
  std::vector<double> logs;
  for (const auto& frame : frames) {
    if (frame) logs.push_back(std::log(frame->factor));
  }
  if (logs.empty()) return std::nullopt;
  const double median = Quantile(logs, 0.5);
  if (!(std::abs(median) > std::log(1 + kLeast))) return std::nullopt;
  const auto n = std::count_if(frames.begin(), frames.end(), [&](const auto& frame) {
    return frame && std::abs(std::log(frame->factor) - median) < kNear &&
           frame->squared_error_px2 < kLeftOfErrors * frame->squared_error_as_told;
  });
  if (static_cast<double>(n) < kShare * static_cast<double>(frames.size())) return std::nullopt;
  return std::exp(median);
}

std::string SizeFactorText(double factor, const TagMap& map) {
  const Tag& tag = map.tags().front();
  std::string out = Format(
      "all sizes of the map's tags are wrong by one factor: by their places to one another they "
      "are "
      "%.3f of what the map says, tag %d %.4g m instead of %.4g m",
      factor, tag.id, factor * tag.size_m, tag.size_m);
  const auto patterns = MakeTagPatterns(map.family(), {tag.id});
  if (!patterns) return out + "; correct size_m, or the positions";
  const TagPattern& pattern = patterns->front();
  const double black_of_all = static_cast<double>(pattern.square_cells) / pattern.cells;
  if (std::abs(std::log(factor / black_of_all)) < 0.03) {
    return out + ": they are given with the white border; size_m is the black square's side";
  }
  return out + "; correct size_m (the black square's side), or the positions";
}

}  // namespace tagtwist::internal
