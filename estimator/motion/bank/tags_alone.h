#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"

namespace tagtwist::internal {

/// A pose, and the covariances of its attitude (in B) and position (in W), taken as independent.
struct PoseMeasurement {
  Pose world_from_body;
  Eigen::Matrix3d attitude_covariance = Eigen::Matrix3d::Zero();
  Eigen::Matrix3d position_covariance = Eigen::Matrix3d::Zero();
  /// Whether the tags agree with one another, so that they outrank what the motion says: at least
  /// three and most of the frame's lie there within 4 sigma, or both of two, which then fit as a
  /// whole; and no mirrored pose explains them as well. A lone tag has nothing to agree with.
  bool is_consensus = false;
  /// Whether no mirrored pose explains them as well.
  bool is_only = false;
  /// What the tags leave open of the attitude, the variance of an axis in the mean [rad^2].
  double open_rad2 = 0;
};

/// What the tags of a frame say among themselves, before anything is known of the motion: least
/// squares by Gauss-Newton from `start`, tags that stand out among the others weighted down
/// (Huber). Where they agree less than their noise lets expect, the covariances grow by as much.
/// nullopt where they do not fix the pose so well that the errors are Gaussian: the attitude to 2
/// degrees.
std::optional<PoseMeasurement> PoseOfTags(const EstimatorSetup& setup, double corner_sigma_px,
                                          const std::vector<TagDetection>& tags, const Pose& start);

/// The tag that a frame's detections are all of; nullopt where there is none, or several.
std::optional<int> LoneTag(const std::vector<TagDetection>& tags);

/// What a lone tag shows of motion: where it lies in the body's frame, and how it is turned about
/// the line of sight, both of which its corners tell well, however open the pose is of which they
/// are. The attitude is the one that the body had if it only turned, the position the one that it
/// had if it only moved; neither is to be compared with another tag's. nullopt where the corners do
/// not fit, where they leave the attitude open by more than 3 degrees an axis, under a rolling
/// shutter, and where no tag is alone.
std::optional<PoseMeasurement> MotionShownByLoneTag(const EstimatorSetup& setup,
                                                    double corner_sigma_px,
                                                    const std::vector<TagDetection>& tags,
                                                    const Pose& start);

}  // namespace tagtwist::internal
