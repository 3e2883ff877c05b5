#pragma once
#include <functional>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/trajectory.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// How a body moves while a rolling shutter takes an image: its pose s seconds after the stamp is
/// at_stamp [+] (s by_s + s^2 by_s2), [+] as of Retract.
struct RowMotion {
  Pose at_stamp;
  using Covariance = Eigen::Matrix<double, 12, 12>;
  PoseStep by_s = PoseStep::Zero(), by_s2 = PoseStep::Zero();  // rad and m
  Covariance covariance = Covariance::Zero();                  // of both, one after the other

  Pose After(double s) const { return Retract(at_stamp, s * by_s + s * s * by_s2); }
};

/// By where a trajectory has the body at the first, the middle and the last row of an image whose
/// stamp it knows as t_ns; nullopt where it has no state.
std::optional<RowMotion> MotionOfRows(
    const EstimatorSetup& setup, int64_t t_ns,
    const std::function<std::optional<StateAndCovariance>(int64_t)>& trajectory);

/// Corners of a rolling shutter's frame as they would be had the whole image been taken at its
/// stamp: each moved by the difference between its projections from the body's pose at the stamp
/// and line_time_s * v later, v its row. What the motion may be off by is in the corners'
/// covariances, as often as there are tags: it is the same error for all. Tags that the map lacks,
/// and corners behind the camera, stay as they are.
std::vector<TagDetection> TagsAsOfStamp(const EstimatorSetup& setup, const RowMotion& motion,
                                        std::vector<TagDetection> tags);
/// The same as of so many seconds after the stamp.
std::vector<TagDetection> TagsAsOf(double after_s, const EstimatorSetup& setup,
                                   const RowMotion& motion, std::vector<TagDetection> tags);

/// Whether the motion is known well enough for that: its corners move by more than they may move
/// otherwise, by the motion's covariance (RMS).
bool IsKnown(double after_s, const EstimatorSetup& setup, const RowMotion& motion,
             const std::vector<TagDetection>& tags);

/// A corner's pixel, and its derivative by a step of the body's pose; false behind the camera.
bool ProjectFrom(const MountedCamera& seen_by, const Pose& world_from_body,
                 const Eigen::Vector3d& corner, Eigen::Vector2d* pixel,
                 Eigen::Matrix<double, 2, 6>* by_step);

/// When the corners were taken, on average, after the stamp: a frame that knows nothing of its
/// shutter has the pose of then. 0 without tags.
int64_t MeanDelayNs(const EstimatorSetup& setup, const std::vector<TagDetection>& tags);

}  // namespace tagtwist::internal
