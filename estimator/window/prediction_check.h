#pragma once
#include <array>
#include <cstdint>
#include <deque>

#include "estimator/graph/trajectory.h"

namespace tagtwist::internal {

/// How well the motion prior predicts over times as long as gaps between tags. Its density is
/// learned from motion between frames; white noise from then on is an assumption, and a body that
/// keeps accelerating drifts further in a second. So each smoothed state is compared with what
/// those before it predicted: the mean NEES per degree of freedom at each of some horizons, of
/// about the last five seconds.
class PredictionCheck {
 public:
  /// By how much the variance of a prediction is to be multiplied, >= 1.
  struct Inflation {
    double linear = 1, angular = 1;  // position and velocity; attitude and rate
    /// The factors for the standard deviations of a state.
    StateVector OfSigmas() const;
  };

  /// A smoothed state that has measurements around it. Stamps must grow.
  void Add(const GraphState& state, const Block& covariance, const MotionPrior& linear,
           const MotionPrior& angular);
  /// For a state gap_s from the last measurement: linear in the horizon between those that were
  /// seen, and on like its square beyond, as for a constant error of the acceleration's slope.
  Inflation At(double gap_s) const;

 private:
  static constexpr std::array<double, 4> kHorizonsS = {0.25, 0.5, 1, 2};
  struct Sum {
    double weight = 0, linear = 0, angular = 0;
  };
  struct Entry {
    int64_t t_ns = 0;
    Trajectory onward;  // of that state alone
  };
  std::deque<Entry> states_;
  std::array<Sum, kHorizonsS.size()> sums_;
};

}  // namespace tagtwist::internal
