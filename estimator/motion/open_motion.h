#pragma once
#include <optional>

#include "estimator/graph/pose_bound.h"
#include "estimator/linear/block.h"
#include "estimator/motion/bank/motion_banks.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// The newest state of a filter, and what it was made with.
struct ArrivedState {
  Block covariance = Block::Identity();
  PoseInformation tags;  // of its frame, at the state
  // Over the interval that ends with it; none of a part that is not open.
  std::optional<MotionPrior> linear, angular;
};

/// What the covariance of the newest state lacks because it is open how lively the motion has been
/// over its interval: the covariance, about that state, of a mixture of the livelier classes that
/// were possible before the frame, by how likely each makes its tags. The tags bound it where they
/// tell the pose.
StateCovariance OpenMotion(const MotionBanks::Prediction& before, const ArrivedState& state);

}  // namespace tagtwist::internal
