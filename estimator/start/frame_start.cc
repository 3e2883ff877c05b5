#include "estimator/start/frame_start.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

#include "estimator/graph/noise_model.h"
#include "estimator/graph/pose_bound.h"
#include "estimator/graph/reprojection.h"
#include "estimator/rig/rig_pose.h"
#include "estimator/start/recording_start.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

double MedianError(const EstimatorSetup& setup, const GraphFrame& frame) {
  const std::vector<double> errors = ReprojectionErrors(setup, frame);
  return errors.empty() ? 1e9 : Quantile(errors, 0.5);
}

// Squared Mahalanobis distance of a pose that the tags say from the predicted one, in the first
// `size` entries of the error state: 3 for the attitude, 6 for the pose.
double SquaredDistance(const EstimatorSetup& setup, const NoiseModel& noise,
                       const std::vector<TagDetection>& tags, const Pose& pose,
                       const StateAndCovariance& predicted, int size) {
  Eigen::MatrixXd covariance = predicted.covariance.topLeftCorner(size, size);
  const auto of_tags = PoseBound(setup, noise.corner_sigma_px, pose, tags);
  if (of_tags) covariance += of_tags->topLeftCorner(size, size);
  const StateVector error = Difference(BodyState{pose, {}}, {predicted.state.world_from_body, {}});
  return error.head(size).dot(covariance.llt().solve(error.head(size)));
}

// The tags that lie where the frame's state says.
std::vector<TagDetection> TagsAtTheirPlace(const EstimatorSetup& setup, const GraphFrame& frame,
                                           const std::vector<TagDetection>& tags, double near_px) {
  std::vector<TagDetection> out;
  out.reserve(tags.size());
  std::vector<double> errors;
  errors.reserve(4);
  for (const TagDetection& tag : tags) {
    errors.clear();
    AddReprojectionErrors(setup, frame.state.world_from_body, tag, &errors);
    const bool all = errors.size() == 4;
    if (all && *std::max_element(errors.begin(), errors.end()) < near_px) out.push_back(tag);
  }
  return out;
}

// Of as many tags here and there those that lie where they were expected are right: the others may
// have a twin.
bool IsAsGood(const std::vector<TagDetection>& expected, const std::vector<TagDetection>& found) {
  return !expected.empty() && expected.size() >= found.size();
}

// Other poses that the corners leave open, as frames.
std::vector<GraphFrame> Others(const GraphFrame& frame, const FramePose& found,
                               const Pose& chosen) {
  std::vector<Pose> poses = found.alternatives;
  poses.push_back(found.world_from_body);
  std::vector<GraphFrame> out;
  for (const Pose& pose : poses) {
    if (pose.params == chosen.params) continue;
    out.push_back(frame);
    out.back().state.world_from_body = pose;
  }
  return out;
}

}  // namespace

FrameStarts StartFrame(const EstimatorSetup& setup, const NoiseModel& noise,
                       const FrameMeasurements& measurement, const GraphFrame* last,
                       const std::optional<StateAndCovariance>& predicted) {
  // The prediction is the better start while it is near; after a gap the tags are.
  constexpr double kFarPx = 5;
  // Motion bursts beyond its prior now and then, by some sigmas; tags that are wrong lie far off.
  constexpr double kExcluded = 200, kPossible = 30;  // squared Mahalanobis distances
  FrameStarts out;
  GraphFrame frame;
  frame.t_ns = measurement.t_ns;
  if (last != nullptr) {
    frame.state = Predict(last->state, ToSeconds(frame.t_ns - last->t_ns));
    frame.acceleration = last->acceleration;
  } else if (measurement.closed_form.twist_ransac) {
    frame.state.twist = *measurement.closed_form.twist_ransac;
  }
  if (predicted && measurement.tags.size() > 1) {  // one alone may have two poses
    frame.state = predicted->state;
    frame.tags = TagsAtTheirPlace(setup, frame, measurement.tags, kFarPx);
    if (frame.tags.size() == measurement.tags.size()) {
      out.starts = {frame};
      return out;
    }
    frame.tags.clear();
  }
  const FramePose found = FindPoseOfTags(setup, measurement.tags);
  const auto pose = ChoosePose(found, last == nullptr ? nullptr : &frame.state.world_from_body);
  if (!pose) {
    if (last != nullptr) out.starts = {frame};
    return out;
  }
  frame.tags = AgreeingTags(measurement.tags, found);
  const bool near = last != nullptr && MedianError(setup, frame) < kFarPx;
  if (!near && predicted && measurement.tags.size() > 1) {
    auto expected = TagsAtTheirPlace(setup, frame, measurement.tags, kFarPx);
    if (IsAsGood(expected, frame.tags)) {
      frame.tags = std::move(expected);
      out.starts = {frame};
      return out;
    }
  }
  if (!near && predicted &&
      SquaredDistance(setup, noise, frame.tags, *pose, *predicted, 6) > kExcluded) {
    frame.tags = TagsAtTheirPlace(setup, frame, measurement.tags, kFarPx);
    if (frame.tags.empty()) out.excluded = *pose;
    out.starts = {frame};
    return out;
  }
  std::vector<GraphFrame> others = Others(frame, found, *pose);
  if (!near) frame.state.world_from_body = *pose;
  out.starts = {frame};
  for (GraphFrame& other : others) {
    if (!predicted || SquaredDistance(setup, noise, frame.tags, other.state.world_from_body,
                                      *predicted, 3) < kPossible) {
      out.starts.push_back(std::move(other));
    }
  }
  return out;
}

}  // namespace tagtwist::internal
