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

// x = D z with z of unit variance a priori: M = 1 + D F'F D / s^2, which is well conditioned, of
// those parameters that have a variance.
struct Scaled {
  Eigen::VectorXd sigmas;  // of all
  std::vector<Eigen::Index> active;
  Eigen::LLT<Eigen::MatrixXd> llt;  // of the active ones, and so is the mean of z
  Eigen::VectorXd mean;
  double log_evidence = 0;

  Eigen::VectorXd MeanOfAll() const;  // of x
};

Eigen::VectorXd Scaled::MeanOfAll() const {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(sigmas.size());
  for (size_t i = 0; i < active.size(); ++i) {
    out(active[i]) = sigmas(active[i]) * mean(static_cast<Eigen::Index>(i));
  }
  return out;
}

Scaled Scale(const LinearEvidence& data, const std::vector<ParameterGroup>& groups, double s) {
  Scaled out;
  out.sigmas = Eigen::VectorXd::Zero(data.gradient.size());
  for (const ParameterGroup& g : groups) out.sigmas.segment(g.first, g.size).setConstant(g.sigma);
  for (Eigen::Index i = 0; i < out.sigmas.size(); ++i) {
    if (out.sigmas(i) > 0) out.active.push_back(i);
  }
  const auto n = static_cast<Eigen::Index>(out.active.size());
  Eigen::MatrixXd m(n, n);  // its lower triangle
  Eigen::VectorXd gradient(n);
  for (Eigen::Index j = 0; j < n; ++j) {
    const Eigen::Index column = out.active[static_cast<size_t>(j)];
    const double scale = out.sigmas(column) / (s * s);
    gradient(j) = scale * data.gradient(column);
    for (Eigen::Index i = j; i < n; ++i) {
      const Eigen::Index row = out.active[static_cast<size_t>(i)];
      m(i, j) = scale * out.sigmas(row) * data.information(row, column);
    }
    m(j, j) += 1;
  }
  out.llt.compute(m);
  out.mean = out.llt.solve(gradient);
  const double log_det = 2 * out.llt.matrixLLT().diagonal().array().log().sum();
  out.log_evidence = -0.5 * (data.dof * std::log(s * s) + data.square_sum / (s * s) -
                             gradient.dot(out.mean) + log_det);
  return out;
}

// Takes the place of a lower triangular matrix by its inverse; what is above it is left alone.
void InvertLower(Eigen::Ref<Eigen::MatrixXd> m) {
  constexpr Eigen::Index kSmall = 32;
  const Eigen::Index n = m.rows();
  if (n <= kSmall) {
    Eigen::MatrixXd inverse = Eigen::MatrixXd::Identity(n, n);
    m.triangularView<Eigen::Lower>().solveInPlace(inverse);
    m.triangularView<Eigen::Lower>() = inverse;
    return;
  }
  const Eigen::Index half = n / 2, rest = n - half;
  InvertLower(m.topLeftCorner(half, half));
  InvertLower(m.bottomRightCorner(rest, rest));
  const Eigen::MatrixXd right =
      m.bottomLeftCorner(rest, half) * m.topLeftCorner(half, half).triangularView<Eigen::Lower>();
  m.bottomLeftCorner(rest, half).noalias() =
      -(m.bottomRightCorner(rest, rest).triangularView<Eigen::Lower>() * right);
}

// Of each parameter of all, the share of its variance that the data leave open.
Eigen::VectorXd LeftOpen(const Scaled& scaled) {
  Eigen::MatrixXd root = scaled.llt.matrixLLT();
  InvertLower(root);
  Eigen::VectorXd out = Eigen::VectorXd::Ones(scaled.sigmas.size());
  for (Eigen::Index i = 0; i < root.cols(); ++i) {
    out(scaled.active[static_cast<size_t>(i)]) = root.col(i).tail(root.rows() - i).squaredNorm();
  }
  return out;
}

// One step of the fixed point; the largest change that it made.
double Step(const LinearEvidence& data, EvidenceFit* fit) {
  const Scaled scaled = Scale(data, fit->groups, fit->noise_scale);
  const Eigen::VectorXd left_open = LeftOpen(scaled), mean = scaled.MeanOfAll();
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
    const double square = (mean.segment(g.first, g.size) / g.sigma).squaredNorm();
    const double factor = std::sqrt(square / determined);
    const double step = std::max(std::clamp(factor, 1e-3, 1e3), g.least / g.sigma);
    change = std::max(change, std::abs(std::log(step)));
    g.sigma *= step;
  }
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
    if (g.sigma != 0 || g.is_given || !g.comes_back) continue;
    const double best = Scale(data, fit->groups, fit->noise_scale).log_evidence;
    g.sigma = start[i].sigma;
    for (int k = 0; Scale(data, fit->groups, fit->noise_scale).log_evidence < best - kOpen; ++k) {
      g.sigma = k < kHalvings ? g.sigma / 2 : 0;
      if (g.sigma == 0) break;
    }
  }
}

// Of the covariance of all parameters; a column for each that is active.
Eigen::MatrixXd RootOfCovariance(const Scaled& scaled) {
  Eigen::MatrixXd inverse = scaled.llt.matrixLLT();
  InvertLower(inverse);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(scaled.sigmas.size(), inverse.cols());
  for (Eigen::Index i = 0; i < inverse.cols(); ++i) {
    const Eigen::Index row = scaled.active[static_cast<size_t>(i)], n = inverse.rows() - i;
    out.row(row).tail(n) = scaled.sigmas(row) * inverse.col(i).tail(n).transpose();
  }
  return out;
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
  fit.mean = scaled.MeanOfAll();
  fit.root = RootOfCovariance(scaled);
  return fit;
}

}  // namespace tagtwist::internal
