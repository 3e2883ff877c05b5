#pragma once
#include "estimator/calibration/calibration.h"
#include "estimator/online/config.h"

namespace tagtwist::internal {

/// What a calibration of the configuration's set-up starts from.
inline CalibrationInput CalibrationInputOf(const Config& config) {
  return {config.set_up, config.estimator, config.calibration};
}

}  // namespace tagtwist::internal
