#include "estimator/motion/open_intervals.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "estimator/motion/motion_bank.h"
#include "residuals/motion_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kReach = 3;       // states on either side that an interval's motion is told of
constexpr int kDecades = 10;    // above the chain's density
constexpr double kNone = -9;    // logarithm of a weight that is as good as none
constexpr double kBeyond = 12;  // below the likeliest density: livelier ones are as good as none

// A part of the motion over an interval along axes of its whitened residual that are independent.
template <int kRows>
struct Residual {
  using Column = Eigen::Matrix<double, kRows, 1>;
  using Square = Eigen::Matrix<double, kRows, kRows>;
  Column r;                              // along the axes
  Eigen::Array<double, kRows, 1> m;      // I - J P J', which is diagonal there
  Eigen::Matrix<double, 36, kRows> p_j;  // P J' of both states
};

Eigen::Matrix<double, 36, 36> OfBoth(const BlockBandedMatrix& covariance, int state) {
  Eigen::Matrix<double, 36, 36> out;
  const Block& between = covariance.At(state + 1, state);
  out << covariance.At(state, state), between.transpose(), between,
      covariance.At(state + 1, state + 1);
  return out;
}

template <int kRows>
Residual<kRows> ResidualAfter(int state, bool is_linear, const SolvedChain& chain, double dt_s) {
  const GraphState &from = chain.states[static_cast<size_t>(state)],
                   &to = chain.states[static_cast<size_t>(state) + 1];
  MotionPrior linear = chain.noise.linear, angular = chain.noise.angular;
  linear.psd *= to.motion.linear;
  angular.psd *= to.motion.angular;
  const std::array<const double*, 4> at = {from.pose.params.data(), from.rates.data(),
                                           to.pose.params.data(), to.rates.data()};
  Eigen::Matrix<double, 18, 1> residual;
  Eigen::Matrix<double, 18, 36> jacobian;
  MotionResidual(dt_s, linear, angular).Linearize(at.data(), &residual, &jacobian);
  const int first_row = (is_linear ? MotionResidual::kLinear : MotionResidual::kAngular).first_row;
  const auto j = jacobian.template middleRows<kRows>(first_row);
  const Eigen::Matrix<double, 36, kRows> p_j = OfBoth(chain.covariance, state) * j.transpose();
  const Eigen::SelfAdjointEigenSolver<typename Residual<kRows>::Square> known(j * p_j);
  Residual<kRows> out;
  out.r = known.eigenvectors().transpose() * residual.template segment<kRows>(first_row);
  out.m = (1 - known.eigenvalues().array()).max(chain.least_share).min(1.0);
  out.p_j = p_j * known.eigenvectors();
  return out;
}

// s - 1 of s = 10^(i + 1).
double More(size_t i) { return std::pow(10.0, static_cast<double>(i + 1)) - 1; }

// Logarithms of how likely the densities are, as many as are not excluded.
template <int kRows>
size_t LogWeights(const Residual<kRows>& interval, double log_prior,
                  std::array<double, kDecades>* logs) {
  double most = log_prior;
  for (size_t i = 0; i < kDecades; ++i) {
    const auto grown = (1 + More(i) * interval.m).eval();
    (*logs)[i] =
        log_prior + 0.5 * (More(i) * interval.r.array().square() / grown - grown.log()).sum();
    most = std::max(most, (*logs)[i]);
    if ((*logs)[i] < most - kBeyond) return i;
  }
  return kDecades;
}

// What of a state's error its neighbour has.
Block Gain(const Block& between, const Block& own) {
  return own.ldlt().solve(between.transpose()).transpose();
}

// The states around an interval, and what each gets of what the states at its ends do. E[z z'] by
// its root: where a state is well known much of z cancels there, and rounding would leave less than
// none.
template <int kRows>
void Reach(int state, const BlockBandedMatrix& covariance, const Residual<kRows>& interval,
           const typename Residual<kRows>::Square& root, OpenInterval* out) {
  using Response = Eigen::Matrix<double, kBlockSize, kRows>;
  const auto spread = [&](const Response& response) -> StateCovariance {
    const Eigen::Matrix<double, 12, kRows> of_body = response.template topRows<12>() * root;
    return of_body * of_body.transpose();
  };
  Response response = interval.p_j.template topRows<kBlockSize>();
  out->spreads = {spread(response)};
  out->first_state = state;
  for (int i = 1; i < kReach && out->first_state > 0; ++i) {
    const int k = --out->first_state;
    response =
        (Gain(covariance.At(k + 1, k).transpose(), covariance.At(k + 1, k + 1)) * response).eval();
    out->spreads.insert(out->spreads.begin(), spread(response));
  }
  response = interval.p_j.template bottomRows<kBlockSize>();
  out->spreads.push_back(spread(response));
  for (int k = state + 2; k < covariance.size() && k <= state + kReach; ++k) {
    response = (Gain(covariance.At(k, k - 1), covariance.At(k - 1, k - 1)) * response).eval();
    out->spreads.push_back(spread(response));
  }
}

template <int kRows>
OpenInterval OpenPart(int state, bool is_linear, const SolvedChain& chain, double dt_s) {
  const MotionBankOptions bank;
  const double log_prior = std::log(-std::expm1(-dt_s / bank.switch_s) / bank.classes);
  const Residual<kRows> interval = ResidualAfter<kRows>(state, is_linear, chain, dt_s);
  OpenInterval out;
  std::array<double, kDecades> logs;
  const size_t n = LogWeights(interval, log_prior, &logs);
  double most = kNone, sum = 0;
  for (size_t i = 0; i < n; ++i) most = std::max(most, logs[i]);
  if (!(most > kNone)) return out;
  auto second = Residual<kRows>::Square::Zero().eval();
  for (size_t i = 0; i < n; ++i) {
    const double weight = std::exp(logs[i] - most);
    const auto variance = (More(i) / (1 + More(i) * interval.m)).eval();
    const auto mean = (variance * interval.r.array()).matrix().eval();
    second += weight * mean * mean.transpose();
    second.diagonal().array() += weight * variance;
    sum += weight;
  }
  const Eigen::LLT<typename Residual<kRows>::Square> llt(second / sum);
  if (llt.info() != Eigen::Success) return out;
  out.log_weight = most + std::log(sum);
  Reach<kRows>(state, chain.covariance, interval, llt.matrixL(), &out);
  return out;
}

// Those that reach no state from there on.
void DropBefore(int state, std::vector<OpenInterval>* intervals) {
  const auto ends = [state](const OpenInterval& open) {
    return open.first_state + static_cast<int>(open.spreads.size()) <= state;
  };
  intervals->erase(std::remove_if(intervals->begin(), intervals->end(), ends), intervals->end());
}

}  // namespace

OpenInterval OpenAfter(int state, bool is_linear, const SolvedChain& chain) {
  const GraphState &from = chain.states[static_cast<size_t>(state)],
                   &to = chain.states[static_cast<size_t>(state) + 1];
  const double dt_s = ToSeconds(to.t_ns - from.t_ns);
  if (to.motion.breaks || !(dt_s > 0)) return {};
  const MotionPrior& prior = is_linear ? chain.noise.linear : chain.noise.angular;
  // On acceleration the third entry is idle.
  return prior.on == WhiteNoiseOn::kJerk ? OpenPart<9>(state, is_linear, chain, dt_s)
                                         : OpenPart<6>(state, is_linear, chain, dt_s);
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

void AddOpenMotion(const SolvedChain& chain, const MotionParts& learned,
                   const ForRanges& for_ranges, std::vector<StateCovariance>* covariances) {
  const int n = chain.covariance.size();
  if (chain.covariance.bandwidth() != 1) return;
  const auto add = [&](bool is_linear, int first, int last) {
    std::vector<OpenInterval> near;
    int next = std::max(first - kReach, 0);
    for (int k = first; k < last; ++k) {
      for (; next < k + kReach && next + 1 < n; ++next) {
        OpenInterval open = OpenAfter(next, is_linear, chain);
        if (!open.spreads.empty()) near.push_back(std::move(open));
      }
      DropBefore(k, &near);
      if (!near.empty()) (*covariances)[static_cast<size_t>(k)] += SpreadOf(k, near);
    }
  };
  for_ranges(covariances->size(), [&](size_t first, size_t last) {
    if (learned.angular) add(false, static_cast<int>(first), static_cast<int>(last));
    if (learned.linear) add(true, static_cast<int>(first), static_cast<int>(last));
  });
}

StateCovariance OpenBeforeTheLast(const SolvedChain& chain, const MotionParts& learned) {
  const int last = chain.covariance.size() - 1;
  StateCovariance out = StateCovariance::Zero();
  if (chain.covariance.bandwidth() != 1) return out;
  for (const bool is_linear : {false, true}) {
    if (!(is_linear ? learned.linear : learned.angular)) continue;
    std::vector<OpenInterval> near;
    for (int k = std::max(last - kReach, 0); k < last - 1; ++k) {
      near.push_back(OpenAfter(k, is_linear, chain));
    }
    out += SpreadOf(last, near);
  }
  return out;
}

void OpenMotionOfWindow::Look(const SolvedChain& chain, int oldest, const MotionParts& learned,
                              bool at_all) {
  if (chain.covariance.bandwidth() != 1) return;
  const int intervals = chain.covariance.size() - oldest - 1,
            last = at_all ? intervals : std::min(kReach, intervals);
  const auto look = [&](bool is_linear, std::vector<OpenInterval>* at) {
    OpenInterval open = OpenAfter(oldest + next_, is_linear, chain);
    open.first_state -= oldest;
    if (!open.spreads.empty()) at->push_back(std::move(open));
  };
  for (; next_ < last; ++next_) {
    if (learned.linear) look(true, &linear_);
    if (learned.angular) look(false, &angular_);
  }
}

StateCovariance OpenMotionOfWindow::Of(int state) const {
  return SpreadOf(state, linear_) + SpreadOf(state, angular_);
}

void OpenMotionOfWindow::Forget(int n_states) {
  next_ = std::max(next_ - n_states, 0);
  for (std::vector<OpenInterval>* intervals : {&linear_, &angular_}) {
    for (OpenInterval& open : *intervals) open.first_state -= n_states;
    DropBefore(0, intervals);
  }
}

}  // namespace tagtwist::internal
