#pragma once
#include <vector>

#include "estimator/calibration/set_up/set_up_fit.h"

namespace tagtwist::internal {

/// Tags of some frames of a run, in threes that follow each other, evenly spread over it: every one
/// until there are kMost, then every second three, and so on.
class TagSample {
 public:
  void Add(const FrameMeasurements& frame);
  const std::vector<SeenTags>& frames() const { return frames_; }
  /// Frames that were added, and those among them with two tags or more.
  size_t count() const { return count_; }
  size_t with_two() const { return with_two_; }

 private:
  static constexpr size_t kMost = 3000;
  size_t count_ = 0, with_two_ = 0;
  size_t stride_ = 1;  // of threes
  std::vector<SeenTags> frames_;
  std::vector<size_t> indices_;  // of frames_, among all that were added
};

}  // namespace tagtwist::internal
