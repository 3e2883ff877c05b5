#include "estimator/motion/open_intervals.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "estimator/linear/block_kernels.h"
#include "estimator/motion/bank/motion_bank.h"
#include "residuals/motion_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kDecades = 10;     // above the chain's density
constexpr double kLittle = 0.1;  // of a variance: what is not worth its work
constexpr double kBeyond = 12;   // below the likeliest density: livelier ones are as good as none

using Square = Eigen::Matrix<double, 9, 9>;

// The motion over an interval, linearised.
struct LinearMotion {
  Eigen::Matrix<double, 18, 1> residual;
  Block of_first, of_second;  // its derivatives by the states at the interval's ends
  double log_prior = 0;       // that one density was livelier
};

LinearMotion MotionAfter(int state, const SolvedChain& chain, double dt_s) {
  const GraphState &from = chain.states[static_cast<size_t>(state)],
                   &to = chain.states[static_cast<size_t>(state) + 1];
  MotionPrior linear = chain.noise.linear, angular = chain.noise.angular;
  linear.psd *= to.motion.linear;
  angular.psd *= to.motion.angular;
  const std::array<const double*, 4> at = {from.pose.params.data(), from.rates.data(),
                                           to.pose.params.data(), to.rates.data()};
  const MotionBankOptions bank;
  LinearMotion out;
  Eigen::Matrix<double, 18, 36> jacobian;
  MotionResidual(dt_s, linear, angular).Linearize(at.data(), &out.residual, &jacobian);
  out.of_first = jacobian.leftCols<kBlockSize>();
  out.of_second = jacobian.rightCols<kBlockSize>();
  out.log_prior = std::log(-std::expm1(-dt_s / bank.switch_s) / bank.classes);
  return out;
}

// What the states at the ends have in common with the residual, -J P (whatever its sign, for all
// that is asked of it are squares), and what they know of it, J P J'.
struct Response {
  Block first = Block::Zero(), second = Block::Zero(), known = Block::Zero();
};

Response ResponseTo(const LinearMotion& motion, int state, const BlockBandedMatrix& covariance) {
  const Block& between = covariance.At(state + 1, state);
  Response out;
  SubtractProduct(motion.of_first, covariance.At(state, state), &out.first);
  SubtractProduct(motion.of_second, between, &out.first);
  SubtractProductTransposed(motion.of_first, between, &out.second);
  SubtractProduct(motion.of_second, covariance.At(state + 1, state + 1), &out.second);
  SubtractProductTransposed(out.first, motion.of_first, &out.known);
  SubtractProductTransposed(out.second, motion.of_second, &out.known);
  return out;
}

// A part's rows of the residual along axes that are independent of one another.
template <int kRows>
struct Axes {
  Eigen::Matrix<double, kRows, kRows> directions;
  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Array<double, kRows, 1> m;  // I - J P J', which is diagonal there
};

template <int kRows>
Axes<kRows> AxesOf(const LinearMotion& motion, const Block& known, int first_row,
                   double least_share) {
  const Eigen::Matrix<double, kRows, kRows> of_part =
      known.block<kRows, kRows>(first_row, first_row);
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, kRows, kRows>> eigen(of_part);
  return {eigen.eigenvectors(),
          eigen.eigenvectors().transpose() * motion.residual.segment<kRows>(first_row),
          (1 - eigen.eigenvalues().array()).max(least_share).min(1.0)};
}

// s - 1 of s = 10^(i + 1).
double More(size_t i) { return std::pow(10.0, static_cast<double>(i + 1)) - 1; }

// Logarithms of how likely the densities are, as many as are not excluded.
template <int kRows>
size_t LogWeights(const Axes<kRows>& axes, double log_prior, std::array<double, kDecades>* logs) {
  double most = log_prior;
  for (size_t i = 0; i < kDecades; ++i) {
    const auto grown = (1 + More(i) * axes.m).eval();
    (*logs)[i] = log_prior +
                 0.5 * ((More(i) * axes.r.array().square() / grown).sum() - std::log(grown.prod()));
    most = std::max(most, (*logs)[i]);
    if ((*logs)[i] < most - kBeyond) return i + 1;
  }
  return kDecades;
}

// How likely it is that the motion was livelier, and what z then does.
struct Livelier {
  double log_weight = -std::numeric_limits<double>::infinity();
  // E[z z'] by its root: where a state is well known much of z cancels there, and rounding would
  // leave less than none. On acceleration the third entry is idle.
  Square root = Square::Zero();
};

// Nothing where it adds little to any variance: P J' E[z z'] J P is at most |E[z z']| P.
template <int kRows>
std::optional<Livelier> LivelierAlong(const Axes<kRows>& axes, double log_prior) {
  using SquareOfPart = Eigen::Matrix<double, kRows, kRows>;
  std::array<double, kDecades> logs;
  const size_t n = LogWeights(axes, log_prior, &logs);
  const double most = *std::max_element(logs.begin(), logs.begin() + n);
  double sum = 0, square = 0;
  SquareOfPart second = SquareOfPart::Zero();
  for (size_t i = 0; i < n; ++i) {
    const double weight = std::exp(logs[i] - most);
    const auto variance = (More(i) / (1 + More(i) * axes.m)).eval();
    const auto mean = (variance * axes.r.array()).matrix().eval();
    second += weight * mean * mean.transpose();
    second.diagonal().array() += weight * variance;
    square += weight * (mean.squaredNorm() + variance.maxCoeff());
    sum += weight;
  }
  if (square / (sum + std::exp(-most)) < kLittle) return std::nullopt;
  const Eigen::LLT<SquareOfPart> llt(second / sum);
  if (llt.info() != Eigen::Success) return std::nullopt;
  Livelier out;
  out.log_weight = most + std::log(sum);
  out.root.topLeftCorner<kRows, kRows>() = axes.directions * SquareOfPart(llt.matrixL());
  return out;
}

std::optional<Livelier> LivelierPart(const LinearMotion& motion, const Block& known, int first_row,
                                     const MotionPrior& prior, double least_share) {
  return prior.on == WhiteNoiseOn::kJerk
             ? LivelierAlong(AxesOf<9>(motion, known, first_row, least_share), motion.log_prior)
             : LivelierAlong(AxesOf<6>(motion, known, first_row, least_share), motion.log_prior);
}

// What a state answers, given what its neighbour does: P_k = P (P of the neighbour)^-1 P_neighbour.
// False where the neighbour's covariance is not positive.
bool Carry(int from, int to, const BlockBandedMatrix& covariance, Block* response) {
  Block l = covariance.At(from, from), out = Block::Zero();
  if (!FactorInPlace(&l)) return false;
  SolveRightTransposed(l, response);
  SolveRight(l, response);
  if (to < from) {
    SubtractProduct(*response, covariance.At(from, to), &out);
  } else {
    SubtractProductTransposed(*response, covariance.At(to, from), &out);
  }
  *response = out;
  return true;
}

// What each state gets of what the states at an interval's ends do, in both directions as far as it
// is told of, from `first_wanted` on.
void Spread(int state, int first_wanted, const BlockBandedMatrix& covariance, Response response,
            const std::optional<Livelier>& angular, const std::optional<Livelier>& linear,
            OpenParts* out) {
  const int first = std::max({state + 1 - OpenIntervals::kReach, first_wanted, 0}),
            end = std::min(state + OpenIntervals::kReach + 1, covariance.size());
  const auto begin = [&](const std::optional<Livelier>& livelier, OpenInterval* open) {
    if (!livelier) return;
    open->log_weight = livelier->log_weight;
    open->first_state = first;
    open->spreads.assign(static_cast<size_t>(std::max(end - first, 0)), StateCovariance::Zero());
  };
  const auto add = [&](const std::optional<Livelier>& livelier, int first_row,
                       const Block& of_state, int k, OpenInterval* open) {
    if (!livelier || k < first) return;
    const Eigen::Matrix<double, 12, 9> of_body =
        of_state.block<9, 12>(first_row, 0).transpose().lazyProduct(livelier->root);
    open->spreads[static_cast<size_t>(k - first)] = of_body.lazyProduct(of_body.transpose());
  };
  const auto add_both = [&](const Block& of_state, int k) {
    add(angular, MotionResidual::kAngular.first_row, of_state, k, &out->angular);
    add(linear, MotionResidual::kLinear.first_row, of_state, k, &out->linear);
  };
  begin(angular, &out->angular);
  begin(linear, &out->linear);
  add_both(response.first, state);
  for (int k = state - 1; k >= first && Carry(k + 1, k, covariance, &response.first); --k) {
    add_both(response.first, k);
  }
  add_both(response.second, state + 1);
  for (int k = state + 2; k < end && Carry(k - 1, k, covariance, &response.second); ++k) {
    add_both(response.second, k);
  }
}

StateCovariance SpreadOf(int state, const std::vector<OpenInterval>& intervals) {
  const auto spread_of = [state](const OpenInterval& interval) -> const StateCovariance* {
    const int i = state - interval.first_state;
    if (i < 0 || i >= static_cast<int>(interval.spreads.size())) return nullptr;
    return &interval.spreads[static_cast<size_t>(i)];
  };
  double most = 0;
  for (const OpenInterval& interval : intervals) {
    if (spread_of(interval) != nullptr) most = std::max(most, interval.log_weight);
  }
  double sum = std::exp(-most);
  StateCovariance out = StateCovariance::Zero();
  for (const OpenInterval& interval : intervals) {
    const StateCovariance* const spread = spread_of(interval);
    if (spread == nullptr) continue;
    const double weight = std::exp(interval.log_weight - most);
    out += weight * *spread;
    sum += weight;
  }
  return out / sum;
}

}  // namespace

OpenParts OpenAfter(int state, const SolvedChain& chain, const MotionParts& learned,
                    int first_wanted) {
  const GraphState &from = chain.states[static_cast<size_t>(state)],
                   &to = chain.states[static_cast<size_t>(state) + 1];
  const double dt_s = ToSeconds(to.t_ns - from.t_ns);
  OpenParts out;
  if (to.motion.breaks || !(dt_s > 0)) return out;
  const LinearMotion motion = MotionAfter(state, chain, dt_s);
  const Response response = ResponseTo(motion, state, chain.covariance);
  const auto livelier = [&](const MotionResidual::Part& part, const MotionPrior& prior) {
    return LivelierPart(motion, response.known, part.first_row, prior, chain.least_share);
  };
  std::optional<Livelier> angular, linear;
  if (learned.angular) angular = livelier(MotionResidual::kAngular, chain.noise.angular);
  if (learned.linear) linear = livelier(MotionResidual::kLinear, chain.noise.linear);
  if (angular || linear) {
    Spread(state, first_wanted, chain.covariance, response, angular, linear, &out);
  }
  return out;
}

void OpenIntervals::Add(OpenParts interval) {
  if (!interval.angular.spreads.empty()) angular_.push_back(std::move(interval.angular));
  if (!interval.linear.spreads.empty()) linear_.push_back(std::move(interval.linear));
}

StateCovariance OpenIntervals::Of(int state) const {
  return SpreadOf(state, angular_) + SpreadOf(state, linear_);
}

void OpenIntervals::CountFrom(int state) {
  for (std::vector<OpenInterval>* intervals : {&angular_, &linear_}) {
    for (OpenInterval& open : *intervals) open.first_state -= state;
    const auto ends = [](const OpenInterval& open) {
      return open.first_state + static_cast<int>(open.spreads.size()) <= 0;
    };
    intervals->erase(std::remove_if(intervals->begin(), intervals->end(), ends), intervals->end());
  }
}

}  // namespace tagtwist::internal
