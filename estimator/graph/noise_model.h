#pragma once
#include <string>

#include "residuals/motion_prior.h"

namespace tagtwist {

/// Noise that the estimate was made with.
struct NoiseModel {
  double corner_sigma_px = 0.5;  // one corner coordinate, beyond a detection's own covariance
  double track_sigma_px = 0.3;   // one track coordinate
  MotionPrior linear{WhiteNoiseOn::kJerk, 30.0};    // [(m/s^3)^2/Hz] or [(m/s^2)^2/Hz]
  MotionPrior angular{WhiteNoiseOn::kJerk, 300.0};  // [(rad/s^3)^2/Hz] or [(rad/s^2)^2/Hz]
  std::string source = "default";  // "default", "learned", "given", or "learned, given" when mixed
  bool corner_is_given = false;    // then a detection's own covariance does not count
};

}  // namespace tagtwist
