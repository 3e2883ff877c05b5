#pragma once
#include <optional>
#include <utility>

#include "estimator/motion/bank/motion_banks.h"

namespace tagtwist::internal {

/// Banks over what the frames' tags show: poses, or where a lone tag lies in the body's frame,
/// which says nothing of where another one does. Beside a lone tag the poses' bank waits.
class FollowingBanks {
 public:
  explicit FollowingBanks(MotionBanks of_poses) : banks(std::move(of_poses)) {}

  MotionBanks banks;

  /// From now on poses, or the places of that tag; of what was not followed before nothing is known
  /// but how lively the motion is. `fresh` are banks that know nothing yet.
  void Follow(const std::optional<int>& tag, const MotionBanks& fresh);
  /// Nothing goes on.
  void StartAnew(const MotionBanks& fresh);
  bool IsOf(const std::optional<int>& tag) const { return tag == tag_; }
  bool Follows(int tag) const { return tag_ == tag && banks.is_measured(); }

 private:
  std::optional<int> tag_;
  std::optional<MotionBanks> of_poses_;  // meanwhile
};

}  // namespace tagtwist::internal
