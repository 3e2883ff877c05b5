#pragma once
#include <cstdint>
#include <random>

#include "tests/support/situations/phantoms.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal {

/// Stamps of a situation's frames, one after the other; where these err the exposures are at a
/// steady clock's ticks, the first a second after zero.
class SituationStamps {
 public:
  SituationStamps(Situation situation, double rate_hz, unsigned seed);
  static bool AreWrong(Situation situation);
  /// Of that frame.
  int64_t Next(int frame);

 private:
  double BurstAt(int frame) const;
  double LateAt(double t_s);

  Situation situation_;
  double rate_hz_;
  Rng rng_;
  std::normal_distribution<double> scatter_;  // of an interval
  double last_s_ = 0;
};

}  // namespace tagtwist::internal
