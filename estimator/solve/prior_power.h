#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/linear_system.h"
#include "estimator/linear/scaled_inverse.h"
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
  /// RawPower drawn towards 1 as far as the recording is too short to tell, within [0.05, 5]; 1
  /// where rounding has made the statistic.
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
/// traces are derivatives of tr(M) by the logarithm of the density. A graph without points is gone
/// through in pieces of so many states, forwards, back, and forwards again: what is kept is a
/// piece's matrices and what crosses from piece to piece. The pieces change the result by rounding.
PriorPower FindPriorPower(const Graph& graph, int states_of_a_piece = 64);

/// The normal equations of consecutive states of a graph, in all and of the motion prior alone.
struct NormalsPiece {
  LinearSystem total, motion;
  int first = 0;     // the graph's state that is theirs first
  PieceColumns own;  // their states whose columns, and those that they reach, are whole
};

/// What FindPriorPower gathers from the pieces of a graph of so many states.
class PriorPowerSums {
 public:
  static constexpr int kScales = 3;  // of the motion's density, the last one its own

  explicit PriorPowerSums(size_t n_states);
  void Forward(const NormalsPiece& piece, size_t number);
  void Back(const NormalsPiece& piece, size_t number, int scale);
  void ForwardAgain(const NormalsPiece& piece, size_t number);
  PriorPower Finish() &&;

 private:
  void Factorise(const NormalsPiece& piece, size_t number, ScaledInverse* inverse);
  Eigen::VectorXd SolveOn(const NormalsPiece& piece, Eigen::VectorXd right);

  std::array<ScaledInverse, kScales> inverses_;
  BlockBandedMatrix matrix_;  // of a piece, for one scale after the other
  PriorPower result_;
  Eigen::VectorXd step_;   // the inverse of total times its gradient
  Eigen::VectorXd right_;  // of the first states of the next piece, of a right side
};

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
  static constexpr int kSteps = PriorPowerSums::kScales;

  NormalsPiece whole_;
  PriorPowerSums sums_;
  PriorPower result_;
  int step_ = 0;
};

/// The states' covariances with the prior's share scaled by the power. States that hang mostly on
/// the prior (gaps) keep theirs where the power is below 1: there the motion that was resolved
/// elsewhere counts, which set the density.
std::vector<StateCovariance> WithPriorPower(double power, PriorPower prior);

}  // namespace tagtwist::internal
