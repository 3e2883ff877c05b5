#include "estimator/systematic/evidence.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

namespace tagtwist::internal {
namespace {

constexpr int kMaxSteps = 30;
constexpr double kSettled = 0.01;  // largest change of a logarithm of a standard deviation
constexpr double kNothing = 1e-3;  // parameters that the data determine of a group that is none
// Twice the logarithm of the ratio of evidences: chi-square of one degree of freedom, 0.1 %.
constexpr double kClearly = 10.8;
constexpr double kOpen = 1;  // of a log evidence: what is no more than this speaks for nothing

// x = D z with z of unit variance a priori: M = 1 + D F'F D / s^2, which is well conditioned and
// holds where a variance is 0.
struct Scaled {
  Eigen::VectorXd sigmas;
  Eigen::LLT<Eigen::MatrixXd> llt;
  Eigen::VectorXd mean;  // of z
  double log_evidence = 0;
};

Scaled Scale(const LinearEvidence& data, const std::vector<ParameterGroup>& groups, double s) {
  Scaled out;
  const Eigen::Index n = data.gradient.size();
  out.sigmas = Eigen::VectorXd::Zero(n);
  for (const ParameterGroup& g : groups) out.sigmas.segment(g.first, g.size).setConstant(g.sigma);
  Eigen::MatrixXd m = out.sigmas.asDiagonal() * data.information * out.sigmas.asDiagonal();
  m /= s * s;
  m.diagonal().array() += 1;
  out.llt.compute(m);
  const Eigen::VectorXd gradient = out.sigmas.cwiseProduct(data.gradient) / (s * s);
  out.mean = out.llt.solve(gradient);
  const double log_det = 2 * out.llt.matrixLLT().diagonal().array().log().sum();
  out.log_evidence = -0.5 * (data.dof * std::log(s * s) + data.square_sum / (s * s) -
                             gradient.dot(out.mean) + log_det);
  return out;
}

// One step of the fixed point; the largest change that it made.
double Step(const LinearEvidence& data, EvidenceFit* fit) {
  const Scaled scaled = Scale(data, fit->groups, fit->noise_scale);
  const Eigen::Index n = data.gradient.size();
  const Eigen::VectorXd left_open = scaled.llt.solve(Eigen::MatrixXd::Identity(n, n)).diagonal();
  double change = 0, known = 0;
  for (ParameterGroup& g : fit->groups) {
    if (g.sigma == 0) continue;
    const double determined = g.size - left_open.segment(g.first, g.size).sum();
    if (g.is_given) {
      known += determined;
      continue;
    }
    if (determined < kNothing) {
      g.sigma = g.least;
      continue;
    }
    known += determined;
    const double square = scaled.mean.segment(g.first, g.size).squaredNorm();
    const double factor = std::sqrt(square / determined);
    const double step = std::max(std::clamp(factor, 1e-3, 1e3), g.least / g.sigma);
    change = std::max(change, std::abs(std::log(step)));
    g.sigma *= step;
  }
  const Eigen::VectorXd mean = scaled.sigmas.cwiseProduct(scaled.mean);
  const double rest = data.square_sum - 2 * mean.dot(data.gradient) +
                      mean.dot(data.information.selfadjointView<Eigen::Lower>() * mean);
  const double s = std::sqrt(std::max(rest, 0.0) / std::max(1.0, data.dof - known));
  if (s > 0) {
    change = std::max(change, std::abs(std::log(s / fit->noise_scale)));
    fit->noise_scale = s;
  }
  return change;
}

void Settle(const LinearEvidence& data, EvidenceFit* fit) {
  for (int k = 0; k < kMaxSteps && Step(data, fit) > kSettled; ++k) {
  }
  fit->log_evidence = Scale(data, fit->groups, fit->noise_scale).log_evidence;
}

// Leaves out the group that the evidence misses least, down to what it has at least; false where it
// misses every one.
bool LeaveOutOne(const LinearEvidence& data, EvidenceFit* fit) {
  ParameterGroup* least = nullptr;
  double least_loss = kClearly / 2;
  for (ParameterGroup& g : fit->groups) {
    if (g.is_given || g.sigma == g.least) continue;
    const double sigma = std::exchange(g.sigma, g.least);
    const double loss = fit->log_evidence - Scale(data, fit->groups, fit->noise_scale).log_evidence;
    g.sigma = sigma;
    if (loss >= least_loss) continue;
    least_loss = loss;
    least = &g;
  }
  if (least == nullptr) return false;
  least->sigma = least->least;
  least->is_given = least->least > 0;  // there it stays
  return true;
}

// Whether the data show a group: what is given is there without them.
bool AnyIsSeen(const EvidenceFit& fit) {
  return std::any_of(fit.groups.begin(), fit.groups.end(),
                     [](const ParameterGroup& g) { return g.sigma > 0 && !g.is_given; });
}

// A group that was left out, though others were not, may be one that the data do not speak of: it
// gets as much of its sigma at the start as they do not speak against.
void PutBackWhatIsOpen(const LinearEvidence& data, const std::vector<ParameterGroup>& start,
                       EvidenceFit* fit) {
  constexpr int kHalvings = 6;
  for (size_t i = 0; i < start.size(); ++i) {
    ParameterGroup& g = fit->groups[i];
    if (g.sigma != 0 || g.is_given) continue;
    const double best = Scale(data, fit->groups, fit->noise_scale).log_evidence;
    g.sigma = start[i].sigma;
    for (int k = 0; Scale(data, fit->groups, fit->noise_scale).log_evidence < best - kOpen; ++k) {
      g.sigma = k < kHalvings ? g.sigma / 2 : 0;
      if (g.sigma == 0) break;
    }
  }
}

}  // namespace

bool EvidenceFit::IsEmpty() const {
  return std::all_of(groups.begin(), groups.end(),
                     [](const ParameterGroup& g) { return g.sigma == 0; });
}

EvidenceFit FitByEvidence(const LinearEvidence& data, std::vector<ParameterGroup> groups) {
  EvidenceFit fit;
  fit.groups = std::move(groups);
  fit.noise_scale = std::sqrt(std::max(data.square_sum, 1e-300) / std::max(data.dof, 1.0));
  const std::vector<ParameterGroup> start = fit.groups;
  do {
    Settle(data, &fit);
  } while (LeaveOutOne(data, &fit));
  if (AnyIsSeen(fit)) PutBackWhatIsOpen(data, start, &fit);
  const Scaled scaled = Scale(data, fit.groups, fit.noise_scale);
  const Eigen::Index n = data.gradient.size();
  fit.mean = scaled.sigmas.cwiseProduct(scaled.mean);
  fit.covariance = scaled.sigmas.asDiagonal() * scaled.llt.solve(Eigen::MatrixXd::Identity(n, n)) *
                   scaled.sigmas.asDiagonal();
  return fit;
}

}  // namespace tagtwist::internal
