#pragma once
#include <array>
#include <optional>

#include "estimator/graph/noise_model.h"
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// Aitken's delta-squared over the fixed-point rounds: every second round jumps to where the last
/// steps, shrinking geometrically, would end. The plain iteration needs many rounds where data say
/// little of a density.
class NoiseExtrapolation {
 public:
  /// The model to go on with after a round took `before` to `updated`.
  NoiseModel Next(const NoiseModel& before, const NoiseModel& updated);

 private:
  using Logs = std::array<double, 6>;   // of sigmas, densities and shakes
  std::optional<Logs> last_step_;       // of the logarithms, in the round before
  Logs jump_{};                         // what the last one added to its round's step
  std::array<bool, 6> went_too_far_{};  // once, so that the next round came back
};

}  // namespace tagtwist::internal
