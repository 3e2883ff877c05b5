#include "frontend/geometry/frame_pose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "frontend/base/option_check.h"
#include "frontend/geometry/homography.h"
#include "frontend/geometry/pose_refine.h"
#include "frontend/geometry/tag_outline.h"
#include "frontend/types/tag_planes.h"

namespace tagtwist::internal {
namespace {

// What all candidates are judged by.
struct SeenTags {
  const std::vector<TagDetection>& tags;  // all in the map
  const TagMap& map;
  const Camera& camera;
  const FramePoseOptions& options;
};

// A pose and the tags that it explains: indices into SeenTags::tags, in order.
struct Candidate {
  RefinedPose pose;
  std::vector<size_t> tags;

  double MeanSquaredError() const {
    return pose.squared_error_px2 / static_cast<double>(std::max<size_t>(tags.size(), 1));
  }
};

bool IsBetter(const Candidate& a, const Candidate& b) {
  if (a.tags.size() != b.tags.size()) return a.tags.size() > b.tags.size();
  return a.MeanSquaredError() < b.MeanSquaredError();
}

bool IsFinite(const TagDetection& tag) {
  return std::all_of(tag.corners.begin(), tag.corners.end(),
                     [](const Eigen::Vector2d& corner) { return corner.allFinite(); });
}

std::vector<PointInImage> Corners(const SeenTags& view, const std::vector<size_t>& tags) {
  std::vector<PointInImage> points;
  for (const size_t i : tags) {
    const auto& corners_in_world = view.map.CornersInWorld(view.tags[i].id);
    for (size_t c = 0; c < 4; ++c) {
      points.push_back({corners_in_world[c], view.tags[i].corners[c]});
    }
  }
  return points;
}

double WorstCornerPx(const SeenTags& view, const TagDetection& tag, const Pose& cam_from_world) {
  double worst = 0;
  for (size_t c = 0; c < 4; ++c) {
    Eigen::Vector2d pixel;
    if (!view.camera.Project(cam_from_world * view.map.CornersInWorld(tag.id)[c], &pixel)) {
      return std::numeric_limits<double>::infinity();
    }
    worst = std::max(worst, (pixel - tag.corners[c]).norm());
  }
  return worst;
}

std::vector<size_t> AgreeingTags(const SeenTags& view, const Pose& cam_from_world, double least_px,
                                 double fraction_of_side) {
  constexpr double kOwnSigmas = 4;
  std::vector<size_t> agreeing;
  for (size_t i = 0; i < view.tags.size(); ++i) {
    const TagDetection& tag = view.tags[i];
    double limit_px = std::max(least_px, fraction_of_side * MeanSidePx(tag));
    if (tag.covariance) {  // corners that are known to scatter
      limit_px = std::max(limit_px, kOwnSigmas * std::sqrt(tag.covariance->diagonal().maxCoeff()));
    }
    if (WorstCornerPx(view, view.tags[i], cam_from_world) <= limit_px) agreeing.push_back(i);
  }
  return agreeing;
}

// Grows the set of agreeing tags from a start made with a few of them: a small tag predicts others
// far from it only roughly, a wrong id is off by about two sides or more.
Candidate Grow(const SeenTags& view, const RefinedPose& start) {
  constexpr int kRounds = 4;
  constexpr double kCoarse = 4, kCoarseFraction = 0.5;
  Candidate out{start, {}};
  for (const bool coarse : {true, false}) {
    const double least_px = view.options.agree_px * (coarse ? kCoarse : 1);
    const double fraction = coarse ? kCoarseFraction : view.options.agree_fraction;
    for (int round = 0; round < kRounds; ++round) {
      auto tags = AgreeingTags(view, out.pose.cam_from_world, least_px, fraction);
      const bool same = tags == out.tags;
      out.tags = std::move(tags);
      if (out.tags.empty()) return out;
      if (same) break;
      out.pose = RefinePose(out.pose.cam_from_world, Corners(view, out.tags), view.camera);
    }
  }
  return out;
}

// The other pose under which points of a plane look the same from afar: the rotation mirrored
// along the line of sight to their centroid, which keeps its place.
Pose MirroredPose(const Pose& cam_from_world, const Pose& world_from_plane,
                  const std::vector<PointInImage>& points) {
  const Pose cam_from_plane = cam_from_world * world_from_plane;
  Eigen::Vector3d centroid_in_world = Eigen::Vector3d::Zero();
  for (const PointInImage& point : points) centroid_in_world += point.point_in_world;
  centroid_in_world /= static_cast<double>(points.size());
  const Eigen::Vector3d centroid_in_cam = cam_from_world * centroid_in_world;
  const Eigen::Vector3d sight = centroid_in_cam.normalized();
  const Eigen::Matrix3d rotation = (Eigen::Matrix3d::Identity() - 2 * sight * sight.transpose()) *
                                   cam_from_plane.rotation().toRotationMatrix() *
                                   Eigen::Vector3d(1, 1, -1).asDiagonal();
  const Eigen::Vector3d centroid_in_plane = Inverse(world_from_plane) * centroid_in_world;
  return MakePose(Eigen::Quaterniond(rotation), centroid_in_cam - rotation * centroid_in_plane) *
         Inverse(world_from_plane);
}

bool AreApart(const Pose& a, const Pose& b) {
  constexpr double kAngleRad = 0.01;
  constexpr double kFraction = 0.01;  // of the distance from the world's origin
  const double distance = std::max(a.translation().norm(), b.translation().norm());
  return a.rotation().angularDistance(b.rotation()) > kAngleRad ||
         (a.translation() - b.translation()).norm() > kFraction * distance;
}

// Both minima of a single tag, grown.
std::vector<Candidate> CandidatesOfTag(const SeenTags& view, size_t index) {
  const TagDetection& tag = view.tags[index];
  const Pose& world_from_tag = view.map.Find(tag.id)->world_from_tag;
  const auto world_from_cam = PoseFromTags({tag}, view.map, world_from_tag, view.camera, {});
  if (!world_from_cam) return {};
  const auto points = Corners(view, {index});
  const RefinedPose first = RefinePose(Inverse(*world_from_cam), points, view.camera);
  const Pose mirrored = MirroredPose(first.cam_from_world, world_from_tag, points);
  const RefinedPose second = RefinePose(mirrored, points, view.camera);
  std::vector<Candidate> out = {Grow(view, first)};
  if (AreApart(first.cam_from_world, second.cam_from_world)) out.push_back(Grow(view, second));
  return out;
}

std::vector<size_t> LargestTags(const SeenTags& view) {
  std::vector<std::pair<double, size_t>> by_size;
  for (size_t i = 0; i < view.tags.size(); ++i) by_size.emplace_back(-MeanSidePx(view.tags[i]), i);
  std::sort(by_size.begin(), by_size.end());
  by_size.resize(std::min(by_size.size(), static_cast<size_t>(view.options.max_candidate_tags)));
  std::vector<size_t> largest;
  largest.reserve(by_size.size());
  for (const auto& entry : by_size) largest.push_back(entry.second);
  return largest;
}

// Candidates until one explains (nearly) all tags.
std::vector<Candidate> Candidates(const SeenTags& view, const TagPlanes& planes) {
  std::vector<Candidate> candidates;
  const Pose& world_from_plane = planes.world_from_plane[MainPlane(planes, view.tags)];
  if (view.tags.size() > 1) {
    std::vector<TagDetection> on_plane;
    for (const TagDetection& tag : view.tags) {
      if (planes.plane_of_tag.at(tag.id) == MainPlane(planes, view.tags)) on_plane.push_back(tag);
    }
    const auto world_from_cam = PoseFromTags(on_plane, view.map, world_from_plane, view.camera, {});
    if (world_from_cam) candidates.push_back(Grow(view, {Inverse(*world_from_cam), 0}));
    if (!candidates.empty() && candidates[0].tags.size() == view.tags.size()) return candidates;
  }
  constexpr double kEnough = 0.8;
  for (const size_t index : LargestTags(view)) {
    for (Candidate& candidate : CandidatesOfTag(view, index)) {
      if (!candidate.tags.empty()) candidates.push_back(std::move(candidate));
    }
    const bool enough =
        view.tags.size() > 2 &&
        std::any_of(candidates.begin(), candidates.end(), [&](const Candidate& candidate) {
          return static_cast<double>(candidate.tags.size()) >=
                 kEnough * static_cast<double>(view.tags.size());
        });
    if (enough) break;
  }
  return candidates;
}

// True when the corners do not tell `other` from `best`: both explain the same tags, nearly as
// well.
bool IsAmbiguous(const SeenTags& view, const Candidate& best, const Candidate& other) {
  constexpr double kSigmas = 4;
  const double limit_px = kSigmas * view.options.ambiguity_px;
  return other.pose.squared_error_px2 - best.pose.squared_error_px2 < limit_px * limit_px;
}

// The other poses to keep: the mirrored minimum, and what as many other tags say.
std::vector<Pose> Alternatives(const SeenTags& view, const TagPlanes& planes, const Candidate& best,
                               std::vector<Candidate> candidates) {
  const auto plane_of = [&](size_t i) { return planes.plane_of_tag.at(view.tags[i].id); };
  const size_t plane = plane_of(best.tags.front());
  if (std::all_of(best.tags.begin(), best.tags.end(),
                  [&](size_t i) { return plane_of(i) == plane; })) {
    const auto points = Corners(view, best.tags);
    const Pose mirrored =
        MirroredPose(best.pose.cam_from_world, planes.world_from_plane[plane], points);
    candidates.push_back({RefinePose(mirrored, points, view.camera), best.tags});
  }
  std::vector<Pose> kept = {best.pose.cam_from_world};
  for (const Candidate& candidate : candidates) {
    const Pose& pose = candidate.pose.cam_from_world;
    const bool possible = candidate.tags == best.tags ? IsAmbiguous(view, best, candidate)
                                                      : candidate.tags.size() == best.tags.size();
    if (possible && std::all_of(kept.begin(), kept.end(),
                                [&](const Pose& other) { return AreApart(pose, other); })) {
      kept.push_back(pose);
    }
  }
  kept.erase(kept.begin());
  return kept;
}

}  // namespace

std::optional<std::string> FramePoseOptions::Problem() const {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (auto& problem :
       {CheckPositive("agree_px", agree_px), CheckRange("agree_fraction", agree_fraction, 0, kInf),
        CheckRange("max_candidate_tags", max_candidate_tags, 1, kInf),
        CheckPositive("ambiguity_px", ambiguity_px)}) {
    if (problem) return problem;
  }
  return std::nullopt;
}

FramePose FindFramePose(const std::vector<TagDetection>& tags, const TagMap& map,
                        const Camera& camera, const Pose& cam_from_body,
                        const FramePoseOptions& options) {
  FramePose found;
  found.tag_inlier.assign(tags.size(), false);
  std::vector<TagDetection> known;
  std::vector<Tag> known_in_map;
  std::vector<size_t> place;  // of a known tag among `tags`
  for (size_t i = 0; i < tags.size(); ++i) {
    const Tag* tag = map.Find(tags[i].id);
    if (tag == nullptr || !IsFinite(tags[i])) continue;
    known.push_back(tags[i]);
    known_in_map.push_back(*tag);
    place.push_back(i);
  }
  if (known.empty()) return found;
  const SeenTags view{known, map, camera, options};
  const TagPlanes planes = FindTagPlanes(known_in_map);
  const std::vector<Candidate> candidates = Candidates(view, planes);
  const auto best = std::min_element(candidates.begin(), candidates.end(), IsBetter);
  found.status = FramePoseStatus::kNoPose;
  if (best == candidates.end() || best->tags.empty()) return found;
  found.status = FramePoseStatus::kOk;
  const auto to_world_from_body = [&](const Pose& cam_from_world) {
    return Inverse(cam_from_world) * cam_from_body;
  };
  found.world_from_body = to_world_from_body(best->pose.cam_from_world);
  found.rms_px = std::sqrt(best->MeanSquaredError() / 4);
  for (const size_t i : best->tags) found.tag_inlier[place[i]] = true;
  for (const Pose& cam_from_world : Alternatives(view, planes, *best, candidates)) {
    found.alternatives.push_back(to_world_from_body(cam_from_world));
  }
  return found;
}

std::optional<Pose> MirroredPose(const std::vector<TagDetection>& tags, const TagMap& map,
                                 const Pose& cam_from_body, const Pose& world_from_body) {
  std::vector<Tag> in_map;
  std::vector<PointInImage> points;
  in_map.reserve(tags.size());
  points.reserve(4 * tags.size());
  for (const TagDetection& tag : tags) {
    in_map.push_back(*map.Find(tag.id));
    for (const Eigen::Vector3d& corner : map.CornersInWorld(tag.id)) {
      points.push_back({corner, Eigen::Vector2d::Zero()});
    }
  }
  const auto plane = CommonPlane(in_map);
  if (!plane) return std::nullopt;
  const Pose cam_from_world = cam_from_body * Inverse(world_from_body);
  return Inverse(MirroredPose(cam_from_world, *plane, points)) * cam_from_body;
}

}  // namespace tagtwist::internal
