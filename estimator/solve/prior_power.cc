#include "estimator/solve/prior_power.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

// Step of the logarithm of the density in the numeric derivatives.
constexpr double kStep = 0.4;

std::vector<bool> MotionFactors(const Graph& graph) {
  std::vector<bool> use;
  for (const Factor& factor : graph.factors) use.push_back(factor.kind == FactorKind::kMotion);
  return use;
}

// total + scale * motion.
BlockBandedMatrix Sum(const BlockBandedMatrix& total, const BlockBandedMatrix& motion,
                      double scale) {
  BlockBandedMatrix out = total;
  for (int j = 0; j < out.size(); ++j) {
    for (int i = j; i <= std::min(out.size() - 1, j + motion.bandwidth()); ++i) {
      out.At(i, j) += scale * motion.At(i, j);
    }
  }
  return out;
}

// tr(a b) of two symmetric matrices, over the blocks within b's band.
double TraceOfProduct(const BlockBandedMatrix& a, const BlockBandedMatrix& b) {
  double sum = 0;
  for (int j = 0; j < b.size(); ++j) {
    sum += a.At(j, j).cwiseProduct(b.At(j, j)).sum();
    for (int i = j + 1; i <= std::min(b.size() - 1, j + b.bandwidth()); ++i) {
      sum += 2 * a.At(i, j).cwiseProduct(b.At(i, j)).sum();
    }
  }
  return sum;
}

// a x of a symmetric matrix.
Eigen::VectorXd Product(const BlockBandedMatrix& a, const Eigen::VectorXd& x) {
  constexpr int kStateSize = BlockBandedMatrix::kSize;
  Eigen::VectorXd out = Eigen::VectorXd::Zero(x.size());
  for (int j = 0; j < a.size(); ++j) {
    const auto x_j = x.segment<kStateSize>(kStateSize * j);
    out.segment<kStateSize>(kStateSize * j) += a.At(j, j) * x_j;
    for (int i = j + 1; i <= std::min(a.size() - 1, j + a.bandwidth()); ++i) {
      out.segment<kStateSize>(kStateSize * i) += a.At(i, j) * x_j;
      out.segment<kStateSize>(kStateSize * j) +=
          a.At(i, j).transpose() * x.segment<kStateSize>(kStateSize * i);
    }
  }
  return out;
}

// Share of the prior in the state's information, in [0, 1].
double PriorShare(const StateCovariance& of_prior, const StateCovariance& covariance) {
  return covariance.ldlt().solve(of_prior).trace() / static_cast<double>(covariance.rows());
}

}  // namespace

PowerStatistic& PowerStatistic::operator+=(const PowerStatistic& other) {
  found += other.found;
  noise_alone += other.noise_alone;
  under_prior += other.under_prior;
  return *this;
}

PowerStatistic PowerStatistic::operator*(double factor) const {
  return {factor * found, factor * noise_alone, factor * under_prior};
}

double PowerStatistic::RawPower() const {
  const double of_motion = under_prior - noise_alone;
  return of_motion > 0.1 ? (found - noise_alone) / of_motion : 1;  // else next to nothing is known
}

double PowerStatistic::Power() const {
  const double of_motion = under_prior - noise_alone;
  if (!(of_motion > 0.1)) return 1;
  // The estimate's variance is about 2 under_prior / of_motion^2; before the data it is near 1.
  const double precision = of_motion * of_motion / (2 * under_prior);
  return std::clamp(1 + (RawPower() - 1) * precision / (1 + precision), 0.05, 5.0);
}

PriorPower FindPriorPower(const Graph& graph) {
  PriorPowerFinder finder(graph);
  while (!finder.done()) finder.Step();
  return finder.result();
}

PriorPowerFinder::PriorPowerFinder(const Graph& graph)
    : total_(Linearize(graph)), motion_(Linearize(graph, MotionFactors(graph))) {
  result_.of_prior.assign(graph.states.size(), StateCovariance::Zero());
  if (graph.states.size() < 2) step_ = kSteps;
}

PriorPowerFinder::BlocksOfInverse PriorPowerFinder::Invert(BlockBandedCholesky cholesky) const {
  const BlockBandedMatrix p = std::move(cholesky).SelectedInverse();
  BlocksOfInverse out;
  out.trace = TraceOfProduct(p, motion_.hessian);
  out.states.reserve(static_cast<size_t>(p.size()));
  for (int k = 0; k < p.size(); ++k) out.states.push_back(p.At(k, k).topLeftCorner<12, 12>());
  return out;
}

std::optional<PriorPowerFinder::BlocksOfInverse> PriorPowerFinder::InvertAt(
    double log_scale) const {
  BlockBandedCholesky cholesky(Sum(total_.hessian, motion_.hessian, std::exp(log_scale) - 1));
  if (!cholesky.ok()) return std::nullopt;
  return Invert(std::move(cholesky));
}

void PriorPowerFinder::Step() {
  switch (step_++) {
    case 0:
      stiff_ = InvertAt(kStep);
      break;
    case 1:
      loose_ = InvertAt(-kStep);
      break;
    default:
      Finish();
  }
}

void PriorPowerFinder::Finish() {
  BlockBandedCholesky middle(std::move(total_.hessian));
  if (!stiff_ || !loose_ || !middle.ok()) return;
  for (size_t i = 0; i < result_.of_prior.size(); ++i) {
    result_.of_prior[i] = (loose_->states[i] - stiff_->states[i]) / (2 * kStep);
  }
  const Eigen::VectorXd gradient =
      motion_.gradient - Product(motion_.hessian, middle.Solve(total_.gradient));
  result_.statistic.found = gradient.dot(middle.Solve(gradient));
  BlocksOfInverse inverse = Invert(std::move(middle));
  result_.covariances = std::move(inverse.states);
  const double trace_loose = std::exp(-kStep) * loose_->trace;
  const double trace_stiff = std::exp(kStep) * stiff_->trace;
  result_.statistic.under_prior = (trace_stiff - trace_loose) / (2 * kStep);
  const double slope = -(trace_loose - 2 * inverse.trace + trace_stiff) / (kStep * kStep);
  result_.statistic.noise_alone = (result_.statistic.under_prior + slope) / 2;
}

std::vector<StateCovariance> WithPriorPower(double power, const PriorPower& prior) {
  std::vector<StateCovariance> out = prior.covariances;
  if (power == 1 || out.empty()) return out;
  std::vector<double> shares;
  for (size_t i = 0; i < out.size(); ++i) {
    shares.push_back(PriorShare(prior.of_prior[i], out[i]));
  }
  const double typical = Quantile(shares, 0.5);
  for (size_t i = 0; i < out.size(); ++i) {
    const double of_measurements = std::clamp((1 - shares[i]) / (1 - typical), 0.0, 1.0);
    const double weight = power < 1 ? of_measurements * of_measurements : 1.0;
    out[i] += weight * (power - 1) * prior.of_prior[i];
  }
  return out;
}

}  // namespace tagtwist::internal
