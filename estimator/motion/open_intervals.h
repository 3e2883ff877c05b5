#pragma once
#include <limits>
#include <vector>

#include "estimator/graph/graph_state.h"
#include "estimator/graph/noise_model.h"
#include "estimator/linear/block_banded.h"
#include "estimator/motion/motion_profile.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// States that the motion ties one to the next, as they were solved.
struct SolvedChain {
  const std::vector<GraphState>& states;
  const BlockBandedMatrix& covariance;  // H^-1 of states and neighbours
  const NoiseModel& noise;
  /// Of what is known of an interval's motion, the least that is taken to be other factors'. Where
  /// they tell next to nothing, rounding leaves less than none, and any motion would seem possible;
  /// in a window, of which a part was linearised elsewhere, sooner.
  double least_share = kOfBatch;
  static constexpr double kOfBatch = 1e-6, kOfWindow = 1e-3;
};

/// What a chain leaves open of one part of the motion over one of its intervals.
struct OpenInterval {
  /// Logarithm of how likely livelier densities are together, against the chain's own.
  double log_weight = -std::numeric_limits<double>::infinity();
  int first_state = 0;
  /// From that state on: what the covariance about the chain's state has more if the interval was
  /// livelier. None where that adds little to any.
  std::vector<StateCovariance> spreads;
};

/// The two parts of the motion, which share nothing.
struct OpenParts {
  OpenInterval angular, linear;
};

/// How lively the motion may have been from `state` to the next, all else being as the chain has
/// it, of the parts whose density was learned: that density against some decades more. With s times
/// the density the interval's whitened residual r has the further part z ~ N(0, (s - 1) I); what is
/// known of r without the interval's prior has the covariance M^-1, M = I - J P J'. So, with
/// G = (I + (s - 1) M)^-1,
///
///   log L_s = (s - 1) r'G r / 2 + log det(G) / 2,   E[z] = (s - 1) G r,   Cov[z] = (s - 1) G,
///
/// of z a state gets P J'z, and s has the probability with which a bank's motion switches. The
/// states before `first_wanted` are not asked for.
OpenParts OpenAfter(int state, const SolvedChain& chain, const MotionParts& learned,
                    int first_wanted = 0);

/// Intervals, and what they say of a state together: of each part one of those that reach it is
/// livelier, or none.
class OpenIntervals {
 public:
  static constexpr int kReach = 3;  // states on either side that an interval's motion is told of

  void Add(OpenParts interval);
  StateCovariance Of(int state) const;
  /// Those that reach no state from there on go; the others count it as the first.
  void CountFrom(int state);

 private:
  std::vector<OpenInterval> angular_, linear_;
};

}  // namespace tagtwist::internal
