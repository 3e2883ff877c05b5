#pragma once
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/result/camera_share.h"
#include "estimator/result/reprojection_tally.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What the frames of a run say of its cameras' images: ReprojectionTally over all, and of several
/// cameras what each has in it. Memory does not grow with the frames.
class RigTally {
 public:
  explicit RigTally(const EstimatorSetup& setup);
  /// A frame with a state and the tags that were used for it. Stamps must grow.
  void AddSolved(const EstimatorSetup& setup, const GraphFrame& frame);
  /// All tags of a frame, used or not.
  void AddSeen(const std::vector<TagDetection>& tags);
  ReprojectionErrorsByPlace Errors() const { return tally_.Errors(); }
  /// Of several cameras one each, in order; of one none.
  std::vector<CameraShare> Shares() const;

 private:
  ReprojectionTally tally_;
  std::vector<CameraShare> shares_;
  std::vector<double> squares_;  // of their coordinates' errors
};

}  // namespace tagtwist::internal
