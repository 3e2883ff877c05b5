#include "estimator/motion/bank/following_banks.h"

namespace tagtwist::internal {
namespace {

// As lively as those were, of the same parts.
MotionBanks AsLively(MotionBanks banks, const MotionBanks& before) {
  banks.FollowOnly(before.follows());
  banks.SetWeights(before.weights());
  return banks;
}

}  // namespace

void FollowingBanks::Follow(const std::optional<int>& tag, const MotionBanks& fresh) {
  if (tag == tag_) return;
  if (!tag_) of_poses_ = banks;
  tag_ = tag;
  banks = AsLively(!tag && of_poses_ ? *of_poses_ : fresh, banks);
}

void FollowingBanks::StartAnew(const MotionBanks& fresh) {
  banks = AsLively(fresh, banks);
  of_poses_.reset();
}

}  // namespace tagtwist::internal
