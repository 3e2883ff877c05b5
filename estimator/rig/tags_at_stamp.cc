#include "estimator/rig/tags_at_stamp.h"

#include <array>
#include <cmath>
#include <utility>

#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

using Jacobian = Eigen::Matrix<double, 2, 6>;  // of a pixel by a step of the pose

// What the motion makes of a tag's corners until after_s.
struct TagRows {
  std::array<Eigen::Vector2d, 4> shifts;
  Eigen::Matrix<double, 8, 12> by_motion = Eigen::Matrix<double, 8, 12>::Zero();  // by_s, by_s2
};

// nullopt of tags that the map lacks; corners behind the camera stay.
std::optional<TagRows> RowsOf(double after_s, const EstimatorSetup& setup, const RowMotion& motion,
                              const TagDetection& tag) {
  if (setup.map.Find(tag.id) == nullptr) return std::nullopt;
  const auto& corners = setup.map.CornersInWorld(tag.id);
  const MountedCamera seen_by = setup.CameraOf(tag.camera);
  const Pose at = motion.After(after_s);
  TagRows out;
  for (size_t c = 0; c < 4; ++c) {
    const double s = seen_by.line_time_s * tag.corners[c].y();
    Eigen::Vector2d then, later;
    Jacobian by_then, by_later;
    out.shifts[c].setZero();
    if (!ProjectFrom(seen_by, at, corners[c], &then, &by_then) ||
        !ProjectFrom(seen_by, motion.After(s), corners[c], &later, &by_later)) {
      continue;
    }
    out.shifts[c] = then - later;
    out.by_motion.middleRows<2>(2 * static_cast<Eigen::Index>(c)) << (s - after_s) * by_later,
        (s * s - after_s * after_s) * by_later;
  }
  return out;
}

// From the first row to the last, of the slowest shutter.
double LongestSweepS(const EstimatorSetup& setup) {
  double out = 0;
  for (int i = 0; i < setup.n_cameras(); ++i) {
    const MountedCamera camera = setup.CameraOf(i);
    const double sweep_s = camera.line_time_s * camera.camera.height;
    if (std::abs(sweep_s) > std::abs(out)) out = sweep_s;
  }
  return out;
}

}  // namespace

// M5.
bool ProjectFrom(const MountedCamera& seen_by, const Pose& world_from_body,
                 const Eigen::Vector3d& corner, Eigen::Vector2d* pixel, Jacobian* by_step) {
  const Eigen::Matrix3d rotation = world_from_body.rotation().toRotationMatrix();
  Eigen::Matrix<double, 2, 3> by_point;
  if (!seen_by.camera.Project(seen_by.CamFromMap(world_from_body) * corner, pixel, &by_point)) {
    return false;
  }
  const Eigen::Matrix<double, 2, 3> beside_cam =
      by_point * seen_by.cam_from_body.rotation().toRotationMatrix();
  if (seen_by.mounted_on == MountedOn::kBody) {
    by_step->leftCols<3>() = beside_cam * Hat(Inverse(world_from_body) * corner);
    by_step->rightCols<3>() = -beside_cam * rotation.transpose();
  } else {
    by_step->leftCols<3>() = -beside_cam * rotation * Hat(corner);
    by_step->rightCols<3>() = beside_cam;
  }
  return true;
}

std::optional<RowMotion> MotionOfRows(
    const EstimatorSetup& setup, int64_t t_ns,
    const std::function<std::optional<StateAndCovariance>(int64_t)>& trajectory) {
  const double whole_s = LongestSweepS(setup);
  const auto half_ns = static_cast<int64_t>(std::llround(0.5e9 * whole_s));
  const auto first = trajectory(t_ns), middle = trajectory(t_ns + half_ns),
             last = trajectory(t_ns + 2 * half_ns);
  if (!first || !middle || !last) return std::nullopt;
  RowMotion out;
  out.at_stamp = first->state.world_from_body;
  const PoseStep half = Difference(middle->state.world_from_body, out.at_stamp),
                 whole = Difference(last->state.world_from_body, out.at_stamp);
  out.by_s = (4 * half - whole) / whole_s;
  out.by_s2 = 2 * (whole - 2 * half) / (whole_s * whole_s);
  // The twist's, attitude first.
  const StateCovariance& p = middle->covariance;
  out.covariance.topLeftCorner<6, 6>() << p.block<3, 3>(9, 9), p.block<3, 3>(9, 6),
      p.block<3, 3>(6, 9), p.block<3, 3>(6, 6);
  return out;
}

std::vector<TagDetection> TagsAsOfStamp(const EstimatorSetup& setup, const RowMotion& motion,
                                        std::vector<TagDetection> tags) {
  return TagsAsOf(0, setup, motion, std::move(tags));
}

std::vector<TagDetection> TagsAsOf(double after_s, const EstimatorSetup& setup,
                                   const RowMotion& motion, std::vector<TagDetection> tags) {
  const auto n = static_cast<double>(tags.size());
  for (TagDetection& tag : tags) {
    const auto rows = RowsOf(after_s, setup, motion, tag);
    if (!rows) continue;
    for (size_t c = 0; c < 4; ++c) tag.corners[c] += rows->shifts[c];
    const Eigen::Matrix<double, 8, 8> open =
        n * rows->by_motion * motion.covariance * rows->by_motion.transpose();
    if (open.isZero(0)) continue;
    tag.covariance = tag.covariance ? Eigen::Matrix<double, 8, 8>(*tag.covariance + open) : open;
  }
  return tags;
}

bool IsKnown(double after_s, const EstimatorSetup& setup, const RowMotion& motion,
             const std::vector<TagDetection>& tags) {
  double open = 0, moved = 0;
  for (const TagDetection& tag : tags) {
    const auto rows = RowsOf(after_s, setup, motion, tag);
    if (!rows) continue;
    open += (rows->by_motion * motion.covariance).cwiseProduct(rows->by_motion).sum();
    for (const Eigen::Vector2d& shift : rows->shifts) moved += shift.squaredNorm();
  }
  return moved > open;
}

int64_t MeanDelayNs(const EstimatorSetup& setup, const std::vector<TagDetection>& tags) {
  if (tags.empty()) return 0;
  double first_sum = 0, sum_s = 0;  // rows of the first camera; delays of the others
  for (const TagDetection& tag : tags) {
    for (const Eigen::Vector2d& corner : tag.corners) {
      if (tag.camera == 0) first_sum += corner.y();
      if (tag.camera != 0) sum_s += setup.CameraOf(tag.camera).line_time_s * corner.y();
    }
  }
  const double n = 4 * static_cast<double>(tags.size());
  return std::llround(1e9 * setup.line_time_s * first_sum / n + 1e9 * sum_s / n);
}

}  // namespace tagtwist::internal
