#pragma once
#include <cstdint>
#include <optional>

#include "frontend/tags/guided_detector.h"

namespace tagtwist::internal {

/// Where a body is likely to be when the next image is taken, from its poses in those before alone:
/// the last twist, and an acceleration that nobody knows, of the size of those seen a moment ago.
class CameraMotion {
 public:
  /// Nothing is known any more.
  void Clear();
  /// The pose of the next image, later than the last one, as its tags say it.
  void Add(int64_t t_ns, const PosePrediction& pose);
  /// nullopt while fewer than three poses are known.
  std::optional<PosePrediction> At(int64_t t_ns) const;

 private:
  struct Known {
    int64_t t_ns = 0;
    PosePrediction pose;
  };
  PosePrediction Predict(int64_t t_ns) const;
  double PerAccel(int64_t t_ns) const;

  std::optional<Known> before_, last_;
  bool has_accel_ = false;
  double accel_ = 0, angular_accel_ = 0;  // [m/s^2], [rad/s^2]
};

}  // namespace tagtwist::internal
