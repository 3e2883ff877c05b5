#pragma once
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// States with an IMU beside those by tags and the motion's prior alone, of frames in order: of
/// each frame whichever is known better. With the IMU the prior on motion is all but out; of a
/// smooth motion it says more than a gyro's samples do (maths.md, "An IMU").
class SurerStates {
 public:
  /// `by_both` becomes `by_tags` where that is surer, and else takes from its rates, where these
  /// are surer, what they say beside the gyro's. Not where what tags and prior say of the motion
  /// does not agree with the IMU, at the frame or over those before it. Whether it became
  /// `by_tags`.
  bool Choose(const FrameEstimate& by_tags, FrameEstimate* by_both);

 private:
  bool Agree(const FrameEstimate& by_tags, const FrameEstimate& by_both);

  // Means over the latest frames, so many and many, of the rates' difference squared, over what
  // both covariances allow: that of many shows a trembling that lies below a frame's noise.
  struct Misfit {
    double frames, mean = 1;
  };
  Misfit of_few_{8}, of_many_{50};
};

}  // namespace tagtwist::internal
