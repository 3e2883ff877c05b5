#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// How the motion prior holds where measurements just cease to resolve the motion. Its density is
/// learned from the motion that they do resolve; how fast the motion's spectrum falls beyond is the
/// prior's assumption, and most flights are smoother. The smoothed states' covariance then promises
/// errors that do not come, up to half of the velocity's variance, or, on rougher flights, too few.
///
/// T of FindPriorPower, and what it would be on average if there were nothing but noise, and if the
/// prior held: of one recording or summed over several pieces.
struct PowerStatistic {
  double found = 0, noise_alone = 0, under_prior = 0;

  PowerStatistic& operator+=(const PowerStatistic& other);
  PowerStatistic operator*(double factor) const;
  /// Power of the motion at the limit of resolution over what the prior expects: 1 where the prior
  /// holds, 0 for motion without anything there. Unbiased, noisy on short recordings.
  double RawPower() const;
  /// RawPower drawn towards 1 as far as the recording is too short to tell, within [0.05, 5].
  double Power() const;
};

struct PriorPower {
  PowerStatistic statistic;
  /// The share of each state's covariance that comes of the prior, P A'A P: the variance of the
  /// smoothed states' bias if the prior holds. The rest is the measurements' noise.
  std::vector<StateCovariance> of_prior;
  std::vector<StateCovariance> covariances;  // of the states, of which that is a part; none where
                                             // the normal equations are not positive definite
};

/// At the solution of a graph, or one step from it: with whitened motion residuals r = A x, the
/// quadratic form T = r'A P A'r weighs the motion most at the limit of resolution. Its expectation
/// is tr(M - M^2) under the prior, tr(M^2 - M^3) if there is nothing but noise, M = P A'A; the
/// traces are derivatives of tr(M) by the logarithm of the density.
PriorPower FindPriorPower(const Graph& graph);

/// FindPriorPower in steps of like length, for whoever has little time at once: the graph is
/// linearised at first, and each of three steps factorises and inverts.
class PriorPowerFinder {
 public:
  explicit PriorPowerFinder(const Graph& graph);
  bool done() const { return step_ == kSteps; }
  void Step();
  /// Once it is done.
  const PriorPower& result() const { return result_; }

 private:
  static constexpr int kSteps = 3;
  // What is needed of an inverse; as a whole it is large, so that there should be one at a time.
  struct BlocksOfInverse {
    double trace = 0;  // tr(inverse motion)
    std::vector<StateCovariance> states;
  };
  BlocksOfInverse Invert(BlockBandedCholesky cholesky) const;
  std::optional<BlocksOfInverse> InvertAt(double log_scale) const;
  void Finish();

  LinearSystem total_, motion_;
  std::optional<BlocksOfInverse> stiff_, loose_;
  PriorPower result_;
  int step_ = 0;
};

/// The states' covariances with the prior's share scaled by the power. States that hang mostly on
/// the prior (gaps) keep theirs where the power is below 1: there the motion that was resolved
/// elsewhere counts, which set the density.
std::vector<StateCovariance> WithPriorPower(double power, const PriorPower& prior);

}  // namespace tagtwist::internal
