#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Homography b_from_a (3x3, unit Frobenius norm, sign free) by DLT: the right singular vector of
/// the smallest singular value of the 2n x 9 matrix of seed Eq. 2. With `normalise`, both point
/// sets are first moved to centroid 0 and mean distance sqrt(2) (Hartley 1997). nullopt with fewer
/// than four points, points not finite, or a configuration that leaves more than one solution.
std::optional<Eigen::Matrix3d> FitHomography(const std::vector<Eigen::Vector2d>& points_in_a,
                                             const std::vector<Eigen::Vector2d>& points_in_b,
                                             bool normalise);

/// Applies a homography; the result is not finite for a point on its horizon.
inline Eigen::Vector2d Transfer(const Eigen::Matrix3d& b_from_a,
                                const Eigen::Vector2d& point_in_a) {
  return (b_from_a * point_in_a.homogeneous()).hnormalized();
}

/// How a homography becomes a pose.
struct HomographyPoseOptions {
  bool normalise_points = true;  // of the DLT
  bool seed_scale = false;  // translation over |r1| (seed Eq. 5), else over the mean |r1|, |r2|
};

/// cam_from_plane of a homography [r1 r2 t] that maps the plane's (x, y) to normalised image
/// coordinates (seed Eqs. 4 and 5). The sign is the one that puts `points_in_plane` in front of
/// the camera; nullopt when they are on both sides of it, or the homography is singular.
std::optional<Pose> PoseFromHomography(const Eigen::Matrix3d& image_from_plane,
                                       const std::vector<Eigen::Vector2d>& points_in_plane,
                                       bool seed_scale);

/// world_from_cam from the corners of tags that lie on one plane (seed section "Part 1"). All tags
/// must be in the map; world_from_plane as in TagPlanes. nullopt when the corners give none.
std::optional<Pose> PoseFromTags(const std::vector<TagDetection>& tags, const TagMap& map,
                                 const Pose& world_from_plane, const Camera& camera,
                                 const HomographyPoseOptions& options);

}  // namespace tagtwist::internal
