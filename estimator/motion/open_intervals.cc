#include "estimator/motion/open_intervals.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estimator/motion/motion_bank.h"
#include "residuals/motion_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kDecades = 10;     // above the chain's density
constexpr double kLittle = 0.1;  // of a variance: what is not worth its work
constexpr double kBeyond = 12;   // below the likeliest density: livelier ones are as good as none

// The motion over an interval, linearised.
struct LinearMotion {
  Eigen::Matrix<double, 18, 1> residual;
  Eigen::Matrix<double, 18, 36> jacobian;
  double log_prior = 0;  // that one density was livelier
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
  MotionResidual(dt_s, linear, angular).Linearize(at.data(), &out.residual, &out.jacobian);
  out.log_prior = std::log(-std::expm1(-dt_s / bank.switch_s) / bank.classes);
  return out;
}

// A part of it: its rows, by the columns that enter them.
template <int kRows>
struct MotionPart {
  using Square = Eigen::Matrix<double, kRows, kRows>;
  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Matrix<double, kRows, 18> j;
  Square known;  // J P J'
};

template <int kRows>
MotionPart<kRows> PartOf(const LinearMotion& motion, const MotionResidual::Part& part, int state,
                         const BlockBandedMatrix& covariance) {
  MotionPart<kRows> out;
  Eigen::Matrix<double, 18, 18> p;
  out.r = motion.residual.template segment<kRows>(part.first_row);
  for (int a = 0; a < 6; ++a) {
    const int of_a = a / 3, column_a = part.columns[static_cast<size_t>(a % 3)];
    out.j.template middleCols<3>(3 * a) =
        motion.jacobian.template block<kRows, 3>(part.first_row, kBlockSize * of_a + column_a);
    for (int b = 0; b <= a; ++b) {
      const int of_b = b / 3, column_b = part.columns[static_cast<size_t>(b % 3)];
      const auto block =
          covariance.At(state + of_a, state + of_b).template block<3, 3>(column_a, column_b);
      p.template block<3, 3>(3 * a, 3 * b) = block;
      if (b < a) p.template block<3, 3>(3 * b, 3 * a) = block.transpose();
    }
  }
  const Eigen::Matrix<double, 18, kRows> p_j = p.lazyProduct(out.j.transpose());
  out.known = out.j.lazyProduct(p_j);
  return out;
}

// The same along axes that are independent of one another.
template <int kRows>
struct Axes {
  typename MotionPart<kRows>::Square directions;
  Eigen::Matrix<double, kRows, 1> r;
  Eigen::Array<double, kRows, 1> m;  // I - J P J', which is diagonal there
};

template <int kRows>
Axes<kRows> AxesOf(const MotionPart<kRows>& part, double least_share) {
  const Eigen::SelfAdjointEigenSolver<typename MotionPart<kRows>::Square> known(part.known);
  return {known.eigenvectors(), known.eigenvectors().transpose() * part.r,
          (1 - known.eigenvalues().array()).max(least_share).min(1.0)};
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

// What each state gets of what the states at an interval's ends do, in both directions as far as it
// is told of, from `first_wanted` on. E[z z'] by its root: where a state is well known much of z
// cancels there, and rounding would leave less than none.
template <int kRows>
void Reach(int state, int first_wanted, const BlockBandedMatrix& covariance,
           const Eigen::Matrix<double, kRows, 36>& jacobian,
           const typename MotionPart<kRows>::Square& root, OpenInterval* out) {
  using Response = Eigen::Matrix<double, kBlockSize, kRows>;
  const auto add = [&](int k, const Response& response) {
    if (k < first_wanted) return;
    const Eigen::Matrix<double, 12, kRows> of_body =
        response.template topRows<12>().lazyProduct(root);
    out->spreads.push_back(of_body.lazyProduct(of_body.transpose()));
  };
  const auto of_first = jacobian.template leftCols<kBlockSize>().transpose(),
             of_second = jacobian.template rightCols<kBlockSize>().transpose();
  const Block& between = covariance.At(state + 1, state);
  Response response = covariance.At(state, state) * of_first + between.transpose() * of_second;
  const Response of_state = response;
  out->first_state = std::max({state + 1 - OpenIntervals::kReach, first_wanted, 0});
  out->spreads.reserve(2 * OpenIntervals::kReach);
  for (int k = state; --k >= out->first_state;) {
    const Response solved = covariance.At(k + 1, k + 1).ldlt().solve(response);
    response = covariance.At(k + 1, k).transpose() * solved;
    add(k, response);
  }
  std::reverse(out->spreads.begin(), out->spreads.end());
  add(state, of_state);
  response = between * of_first + covariance.At(state + 1, state + 1) * of_second;
  add(state + 1, response);
  for (int k = state + 2; k < covariance.size() && k <= state + OpenIntervals::kReach; ++k) {
    const Response solved = covariance.At(k - 1, k - 1).ldlt().solve(response);
    response = covariance.At(k, k - 1) * solved;
    add(k, response);
  }
}

// E[z z'] where the motion was livelier, along the axes, and how likely that is.
template <int kRows>
struct Livelier {
  typename MotionPart<kRows>::Square second;
  double log_weight;
  bool adds_little;  // to any variance: P J' E[z z'] J P is at most |E[z z']| P
};

template <int kRows>
Livelier<kRows> LivelierThan(const Axes<kRows>& axes, double log_prior) {
  std::array<double, kDecades> logs;
  const size_t n = LogWeights(axes, log_prior, &logs);
  const double most = *std::max_element(logs.begin(), logs.begin() + n);
  double sum = 0, square = 0;
  auto second = MotionPart<kRows>::Square::Zero().eval();
  for (size_t i = 0; i < n; ++i) {
    const double weight = std::exp(logs[i] - most);
    const auto variance = (More(i) / (1 + More(i) * axes.m)).eval();
    const auto mean = (variance * axes.r.array()).matrix().eval();
    second += weight * mean * mean.transpose();
    second.diagonal().array() += weight * variance;
    square += weight * (mean.squaredNorm() + variance.maxCoeff());
    sum += weight;
  }
  return {second / sum, most + std::log(sum), square / (sum + std::exp(-most)) < kLittle};
}

template <int kRows>
OpenInterval OpenPart(int state, const SolvedChain& chain, int first_wanted,
                      const LinearMotion& motion, const MotionResidual::Part& which) {
  const Axes<kRows> axes =
      AxesOf(PartOf<kRows>(motion, which, state, chain.covariance), chain.least_share);
  const Livelier<kRows> livelier = LivelierThan(axes, motion.log_prior);
  OpenInterval out;
  if (livelier.adds_little) return out;
  const Eigen::LLT<typename MotionPart<kRows>::Square> llt(livelier.second);
  if (llt.info() != Eigen::Success) return out;
  out.log_weight = livelier.log_weight;
  const typename MotionPart<kRows>::Square root = llt.matrixL();
  Reach<kRows>(state, first_wanted, chain.covariance,
               motion.jacobian.template middleRows<kRows>(which.first_row), axes.directions * root,
               &out);
  return out;
}

OpenInterval OpenPart(int state, const SolvedChain& chain, int first_wanted,
                      const LinearMotion& motion, const MotionResidual::Part& which,
                      const MotionPrior& prior) {
  // On acceleration the third entry is idle.
  return prior.on == WhiteNoiseOn::kJerk ? OpenPart<9>(state, chain, first_wanted, motion, which)
                                         : OpenPart<6>(state, chain, first_wanted, motion, which);
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
  if (learned.angular) {
    out.angular =
        OpenPart(state, chain, first_wanted, motion, MotionResidual::kAngular, chain.noise.angular);
  }
  if (learned.linear) {
    out.linear =
        OpenPart(state, chain, first_wanted, motion, MotionResidual::kLinear, chain.noise.linear);
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
