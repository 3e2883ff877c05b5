#pragma once
#include <Eigen/Geometry>
#include <cmath>
#include <random>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/so3.h"
#include "frontend/types/tag_map.h"
#include "tests/support/draws.h"

namespace tagtwist::internal {

/// The course's extrinsic, seed Eq. 1.
inline Pose CourseCamFromBody() {
  const double c = std::sqrt(0.5);
  Eigen::Matrix3d rotation;
  rotation << c, -c, 0, -c, -c, 0, 0, 0, -1;
  return MakePose(Eigen::Quaterniond(rotation), {-0.04, 0, -0.03});
}

/// A body that hovers over the mat: turned by `yaw`, then tilted by the rotation vector `tilt`.
inline Pose Hover(const Eigen::Vector3d& position, double yaw = 0,
                  const Eigen::Vector3d& tilt = Eigen::Vector3d::Zero()) {
  return MakePose(ExpSo3({0, 0, yaw}) * ExpSo3(tilt), position);
}

/// The tags that lie wholly in the image, at least 2 px from its border; Gaussian corner noise.
inline std::vector<TagDetection> SeeTags(const TagMap& map, const Camera& camera,
                                         const Pose& cam_from_world, double noise_px = 0,
                                         unsigned seed = 1) {
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal(0, 1);
  std::vector<TagDetection> tags;
  for (const Tag& tag : map.tags()) {
    TagDetection seen;
    seen.id = tag.id;
    bool whole = true;
    for (size_t c = 0; c < 4; ++c) {
      whole = whole &&
              camera.Project(cam_from_world * map.CornersInWorld(tag.id)[c], &seen.corners[c]) &&
              camera.Contains(seen.corners[c], 2);
    }
    if (!whole) continue;
    for (auto& corner : seen.corners) {
      corner += noise_px * DrawVector<2>(normal, engine);
    }
    tags.push_back(seen);
  }
  return tags;
}

inline double RotationErrorRad(const Pose& a, const Pose& b) {
  return a.rotation().angularDistance(b.rotation());
}
inline double PositionErrorM(const Pose& a, const Pose& b) {
  return (a.translation() - b.translation()).norm();
}

}  // namespace tagtwist::internal
