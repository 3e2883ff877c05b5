#include "estimator/window/prediction_check.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "frontend/types/nees.h"

namespace tagtwist::internal {
namespace {

constexpr double kSpacingS = 0.05;           // between states that are kept
constexpr double kSumsFade = 1 - 1.0 / 100;  // of the sums, from one of them to the next

// Position and velocity, attitude and rate.
constexpr std::array<int, 2> kLinear = {3, 6}, kAngular = {0, 9};

}  // namespace

void PredictionCheck::Add(const GraphState& state, const Block& covariance,
                          const MotionPrior& linear, const MotionPrior& angular) {
  if (!states_.empty() && ToSeconds(state.t_ns - states_.back().t_ns) < kSpacingS) return;
  const BodyState found = ToBodyState(state);
  for (size_t h = 0; h < kHorizonsS.size(); ++h) {
    // The latest state that lies so far back, if not much further.
    const auto at_least = [&](const Entry& entry) {
      return ToSeconds(state.t_ns - entry.t_ns) >= kHorizonsS[h];
    };
    const auto past = std::find_if(states_.rbegin(), states_.rend(), at_least);
    if (past == states_.rend()) continue;
    if (ToSeconds(state.t_ns - past->t_ns) > 1.3 * kHorizonsS[h]) continue;
    const auto predicted = past->onward.At(state.t_ns);
    const StateCovariance p = predicted->covariance + covariance.topLeftCorner<12, 12>();
    const auto linear_nees = Nees(found, predicted->state, p, kLinear);
    const auto angular_nees = Nees(found, predicted->state, p, kAngular);
    if (!linear_nees || !angular_nees) continue;
    Sum& sum = sums_[h];
    sum.weight = kSumsFade * sum.weight + 1;
    sum.linear = kSumsFade * sum.linear + *linear_nees / 6;
    sum.angular = kSumsFade * sum.angular + *angular_nees / 6;
  }
  states_.push_back({state.t_ns, {{state}, {covariance}, {}, linear, angular}});
  while (ToSeconds(state.t_ns - states_.front().t_ns) > 1.3 * kHorizonsS.back()) {
    states_.pop_front();
  }
}

StateVector PredictionCheck::Inflation::OfSigmas() const {
  StateVector out;
  out.segment<3>(0).setConstant(std::sqrt(angular));
  out.segment<6>(3).setConstant(std::sqrt(linear));
  out.segment<3>(9).setConstant(std::sqrt(angular));
  return out;
}

PredictionCheck::Inflation PredictionCheck::At(double gap_s) const {
  constexpr double kLeastWeight = 3;  // samples
  Inflation below;                    // at horizon
  double horizon_s = 0;
  for (size_t h = 0; h < kHorizonsS.size(); ++h) {
    const Sum& sum = sums_[h];
    if (sum.weight < kLeastWeight) break;
    const Inflation here{std::max(1.0, sum.linear / sum.weight),
                         std::max(1.0, sum.angular / sum.weight)};
    if (gap_s <= kHorizonsS[h]) {
      const double share = (gap_s - horizon_s) / (kHorizonsS[h] - horizon_s);
      return {below.linear + share * (here.linear - below.linear),
              below.angular + share * (here.angular - below.angular)};
    }
    below = here;
    horizon_s = kHorizonsS[h];
  }
  if (horizon_s == 0) return below;
  const double ratio = gap_s / horizon_s;
  return {1 + (below.linear - 1) * ratio * ratio, 1 + (below.angular - 1) * ratio * ratio};
}

}  // namespace tagtwist::internal
