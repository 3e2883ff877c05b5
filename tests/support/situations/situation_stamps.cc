#include "tests/support/situations/situation_stamps.h"

#include <algorithm>
#include <cmath>

#include "tests/support/situations/phantoms.h"

namespace tagtwist::internal {

SituationStamps::SituationStamps(Situation situation, double rate_hz, unsigned seed)
    : situation_(situation), rate_hz_(rate_hz), rng_(seed), scatter_(0, Draw(&rng_, 0.06, 0.2)) {}

bool SituationStamps::AreWrong(Situation situation) {
  return situation == Situation::kJitter || situation == Situation::kBursts ||
         situation == Situation::kLate;
}

// Half a millisecond apart, when the second of two has come.
double SituationStamps::BurstAt(int frame) const {
  const double second = 2 * std::floor(0.5 * frame) + 1;
  return second / rate_hz_ - (frame % 2 == 0 ? 5e-4 : 0);
}

// Now and then late, and after the one before.
double SituationStamps::LateAt(double t_s) {
  constexpr double kLeastS = 5e-4;
  const bool is_late = Draw(&rng_, 0, 1) < 0.1;
  const double late_s = is_late ? -std::log(Draw(&rng_, 1e-6, 1)) / (3 * rate_hz_) : 0;
  last_s_ = std::max(last_s_ + kLeastS, t_s + late_s);
  return last_s_;
}

int64_t SituationStamps::Next(int frame) {
  double t_s = frame / rate_hz_;
  if (situation_ == Situation::kJitter) t_s += std::clamp(scatter_(rng_), -0.4, 0.4) / rate_hz_;
  if (situation_ == Situation::kBursts) t_s = BurstAt(frame);
  if (situation_ == Situation::kLate) t_s = LateAt(t_s);
  return 1'000'000'000 + static_cast<int64_t>(std::llround(1e9 * t_s));
}

}  // namespace tagtwist::internal
