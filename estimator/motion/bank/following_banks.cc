#include "estimator/motion/bank/following_banks.h"

namespace tagtwist::internal {

void FollowingBanks::Follow(const std::optional<int>& tag, const MotionBanks& fresh) {
  if (tag == tag_) return;
  const MotionBanks before = banks;
  if (!tag_) of_poses_ = before;
  tag_ = tag;
  banks = !tag && of_poses_ ? *of_poses_ : fresh;
  banks.FollowOnly(before.follows());
  banks.SetWeights(before.weights());
}

void FollowingBanks::StartAnew(const MotionBanks& fresh) {
  const MotionBanks before = banks;
  banks = fresh;
  banks.FollowOnly(before.follows());
  banks.SetWeights(before.weights());
  of_poses_.reset();
}

}  // namespace tagtwist::internal
