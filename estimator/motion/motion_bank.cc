#include "estimator/motion/motion_bank.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tagtwist::internal {
namespace {

// A class is never ruled out: it may be the right one later.
constexpr double kLeastWeight = 1e-30;

void Normalise(std::vector<double>* weights) {
  double sum = 0;
  for (const double w : *weights) sum += w;
  for (double& w : *weights) w /= sum;
}

// Blocks of a covariance: those of the upper triangle, in this order.
enum Entry { kXx, kXv, kXa, kVv, kVa, kAa };
constexpr Entry kBlocks[3][3] = {{kXx, kXv, kXa}, {kXv, kVv, kVa}, {kXa, kVa, kAa}};

using Blocks = MotionBank::Filter;

Eigen::Map<Eigen::Vector3d> Mean(Blocks* filter, int i) {
  return Eigen::Map<Eigen::Vector3d>(filter->data() + 3 * i);
}

Eigen::Map<const Eigen::Vector3d> Mean(const Blocks& filter, int i) {
  return Eigen::Map<const Eigen::Vector3d>(filter.data() + 3 * i);
}

Eigen::Map<Eigen::Matrix3d> Part(Blocks* filter, Entry block) {
  return Eigen::Map<Eigen::Matrix3d>(filter->data() + 9 + 9 * block);
}

Eigen::Map<const Eigen::Matrix3d> Part(const Blocks& filter, Entry block) {
  return Eigen::Map<const Eigen::Matrix3d>(filter.data() + 9 + 9 * block);
}

// The mean from another origin.
void Move(const MotionBank::State& by, Blocks* filter) { filter->head<9>() += by; }

// Adds the products of the means, times `sign`: from covariance to second moment, and back.
void AddSquareOfMean(double sign, Blocks* filter) {
  for (int i = 0; i < 3; ++i) {
    const Eigen::Vector3d scaled = sign * Mean(*filter, i);
    for (int j = i; j < 3; ++j) {
      Part(filter, kBlocks[i][j]).noalias() += scaled.lazyProduct(Mean(*filter, j).transpose());
    }
  }
}

// F x and F P F', F that of an axis, upper triangular, for all three alike.
void Propagate(const Eigen::Matrix3d& f, Blocks* filter) {
  const auto twice = [](const Eigen::Matrix3d& m) -> Eigen::Matrix3d { return m + m.transpose(); };
  const double a = f(0, 1), b = f(0, 2), c = f(1, 2);
  const Eigen::Vector3d d = f.diagonal();
  Mean(filter, 0) = d(0) * Mean(*filter, 0) + a * Mean(*filter, 1) + b * Mean(*filter, 2);
  Mean(filter, 1) = d(1) * Mean(*filter, 1) + c * Mean(*filter, 2);
  Mean(filter, 2) *= d(2);
  const Eigen::Matrix3d xv = Part(*filter, kXv), xa = Part(*filter, kXa), vv = Part(*filter, kVv),
                        va = Part(*filter, kVa), aa = Part(*filter, kAa);
  const Eigen::Matrix3d two_va = twice(va);
  Part(filter, kXx) = d(0) * d(0) * Part(*filter, kXx) + d(0) * a * twice(xv) +
                      d(0) * b * twice(xa) + a * a * vv + a * b * two_va + b * b * aa;
  Part(filter, kXv) = d(0) * d(1) * xv + d(0) * c * xa + a * d(1) * vv + a * c * va +
                      b * d(1) * va.transpose() + b * c * aa;
  Part(filter, kXa) = d(2) * (d(0) * xa + a * va + b * aa);
  Part(filter, kVv) = d(1) * d(1) * vv + c * d(1) * two_va + c * c * aa;
  Part(filter, kVa) = d(2) * (d(1) * va + c * aa);
  Part(filter, kAa) *= d(2) * d(2);
}

void AddNoise(const Eigen::Matrix3d& q, Blocks* filter) {
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) Part(filter, kBlocks[i][j]).diagonal().array() += q(i, j);
  }
}

// Logarithm of the likelihood. The blocks of x are products, not differences: after a long gap the
// prediction is no help, and differences would be of equals.
double Update(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance, Blocks* filter) {
  const Eigen::Matrix3d s = Part(*filter, kXx) + covariance;
  const Eigen::LLT<Eigen::Matrix3d> llt(s);
  const Eigen::Matrix3d root = llt.matrixL();
  const Eigen::Vector3d error = x - Mean(*filter, 0), whitened = llt.matrixL().solve(error);
  Eigen::Matrix3d known[3], gain[3];  // known' known of the covariance is so from now on
  for (int i = 0; i < 3; ++i) {
    known[i] = llt.matrixL().solve(Part(*filter, kBlocks[0][i]));
    gain[i] = llt.matrixU().solve(known[i]).transpose();
    Mean(filter, i).noalias() += gain[i].lazyProduct(error);
  }
  for (int i = 1; i < 3; ++i) {
    auto own = Part(filter, kBlocks[i][i]);
    const Eigen::Vector3d least = 1e-14 * own.diagonal();  // where rounding leaves less than none
    for (int j = i; j < 3; ++j) {
      Part(filter, kBlocks[i][j]).noalias() -= known[i].transpose().lazyProduct(known[j]);
    }
    own.diagonal() = own.diagonal().cwiseMax(least).eval();
  }
  for (int i = 0; i < 3; ++i) {
    Part(filter, kBlocks[0][i]).noalias() = covariance.lazyProduct(gain[i].transpose());
  }
  for (const Entry block : {kXx, kVv, kAa}) {
    auto square = Part(filter, block);
    square = (0.5 * (square + square.transpose())).eval();
  }
  return -0.5 * whitened.squaredNorm() - root.diagonal().array().log().sum();
}

}  // namespace

MotionBankOptions LinearBankOptions(WhiteNoiseOn on) {
  MotionBankOptions out;
  out.on = on;
  if (on == WhiteNoiseOn::kAcceleration) out.least_density = 1e-10;
  return out;
}

MotionBankOptions AngularBankOptions(WhiteNoiseOn on) {
  MotionBankOptions out = LinearBankOptions(on);
  out.least_density *= 10;
  out.first_rate_sigma = 200;
  out.first_acceleration_sigma = 500;
  return out;
}

MotionBank::MotionBank(const MotionBankOptions& options) : options_(options) {
  const auto n = static_cast<size_t>(options.classes);
  weights_.assign(n, 1.0 / options.classes);
  filters_.assign(n, Fresh());
  for (int i = 0; i < options.classes; ++i) {
    densities_.push_back(options.least_density * std::pow(options.ratio, i));
  }
}

// Nothing is known of x.
MotionBank::Filter MotionBank::Fresh() const {
  constexpr double kAnywhere = 1e3;  // m, or rad
  const bool has_acceleration = options_.on == WhiteNoiseOn::kJerk;
  const double a = has_acceleration ? options_.first_acceleration_sigma : 0;
  Filter out = Filter::Zero();
  Part(&out, kXx).diagonal().setConstant(kAnywhere * kAnywhere);
  Part(&out, kVv).diagonal().setConstant(std::pow(options_.first_rate_sigma, 2));
  Part(&out, kAa).diagonal().setConstant(a * a);
  return out;
}

// Each class takes over from those that may switch to it. Sums over all lower classes grow from one
// class to the next, so that the work is linear in the number of classes.
void MotionBank::Mix(double dt_s) {
  const size_t n = filters_.size();
  if (n < 2) return;
  const double stay = std::exp(-dt_s / options_.switch_s);
  const State centre = Mean();
  std::vector<double> leaves(n);  // weight that goes to each class that may follow
  for (size_t i = 0; i < n; ++i) {
    Move(-centre, &filters_[i]);
    AddSquareOfMean(1, &filters_[i]);
    const double others = static_cast<double>(n - 1 - i) + (i > 0 ? 1 : 0);
    leaves[i] = (1 - stay) * weights_[i] / others;
  }
  double lower = 0;
  Filter of_lower = Filter::Zero();
  for (size_t j = 0; j < n; ++j) {
    const double stays = stay * weights_[j], above = j + 1 < n ? leaves[j + 1] : 0;
    const double weight = stays + lower + above + kLeastWeight;
    Filter mixed = stays * filters_[j] + of_lower;
    if (above > 0) mixed += above * filters_[j + 1];
    lower += leaves[j];
    of_lower += leaves[j] * filters_[j];
    mixed /= weight;
    AddSquareOfMean(-1, &mixed);
    Move(centre, &mixed);
    filters_[j] = mixed;
    weights_[j] = weight;
  }
  Normalise(&weights_);
}

void MotionBank::Predict(double dt_s) {
  Mix(dt_s);
  const Eigen::Matrix3d f = Transition(options_.on, dt_s);
  Eigen::Matrix3d q = ProcessCovariance({options_.on, 1.0, false, options_.shake_s}, dt_s);
  if (options_.on == WhiteNoiseOn::kAcceleration) q(2, 2) = 0;  // the idle acceleration
  for (size_t i = 0; i < filters_.size(); ++i) {
    Propagate(f, &filters_[i]);
    AddNoise(densities_[i] * q, &filters_[i]);
  }
}

void MotionBank::Measure(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance) {
  std::vector<double> logs(filters_.size());
  for (size_t i = 0; i < filters_.size(); ++i) {
    double log = Update(x, covariance, &filters_[i]);
    if (!std::isfinite(log)) {  // what no number holds any more
      filters_[i] = Fresh();
      log = Update(x, covariance, &filters_[i]);
    }
    logs[i] = std::log(weights_[i]) + log;
  }
  const double most = *std::max_element(logs.begin(), logs.end());
  double sum = 0;
  for (size_t i = 0; i < logs.size(); ++i) {
    weights_[i] = std::exp(logs[i] - most);
    sum += weights_[i];
    weights_[i] = std::max(weights_[i], kLeastWeight);
  }
  log_likelihood_ = most + std::log(sum);
  Normalise(&weights_);
}

void MotionBank::SetLeastDensity(double density) {
  const double by = density / densities_.front();
  for (double& d : densities_) d *= by;
}

double MotionBank::DensityOf(const std::vector<double>& weights) const {
  double sum = 0;
  for (size_t i = 0; i < weights.size(); ++i) sum += weights[i] * std::log(densities_[i]);
  return std::exp(sum);
}

MotionBank::State MotionBank::Mean() const {
  State out = State::Zero();
  for (size_t i = 0; i < filters_.size(); ++i) out += weights_[i] * filters_[i].head<9>();
  return out;
}

MotionBank::Covariance MotionBank::MixtureCovariance() const {
  const State mean = Mean();
  Filter sum = Filter::Zero();
  for (size_t i = 0; i < filters_.size(); ++i) {
    Filter filter = filters_[i];
    Move(-mean, &filter);
    AddSquareOfMean(1, &filter);
    sum += weights_[i] * filter;
  }
  return CovarianceOf(sum);
}

MotionBank::Covariance MotionBank::CovarianceOf(const Filter& filter) {
  Covariance out;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      out.block<3, 3>(3 * i, 3 * j) = Part(filter, kBlocks[i][j]);
      out.block<3, 3>(3 * j, 3 * i) = Part(filter, kBlocks[i][j]).transpose();
    }
  }
  return out;
}

void MotionBank::TurnTime(const Eigen::Vector3d& origin, Filter* filter) {
  tagtwist::internal::Mean(filter, 0) += origin;
  tagtwist::internal::Mean(filter, 1) *= -1;
  for (const Entry block : {kXv, kVa}) Part(filter, block) *= -1;
}

std::vector<MotionBank::Class> MotionBank::Classes(double least_weight) const {
  std::vector<Class> out;
  out.reserve(filters_.size());
  for (size_t i = 0; i < filters_.size(); ++i) {
    if (weights_[i] >= least_weight) out.push_back({i, densities_[i], weights_[i], filters_[i]});
  }
  return out;
}

Eigen::Vector2d MotionBank::ExcessVariance() const {
  const State mean = Mean();
  Eigen::Vector2d mixture = Eigen::Vector2d::Zero(), log_of_mean = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < filters_.size(); ++i) {
    for (int part = 0; part < 2; ++part) {
      const double own = Part(filters_[i], kBlocks[part][part]).trace();
      const double apart = (filters_[i].head<9>() - mean).segment<3>(3 * part).squaredNorm();
      mixture(part) += weights_[i] * (own + apart);
      log_of_mean(part) += weights_[i] * std::log(own);  // a variance goes with a density's power
    }
  }
  constexpr int kAxes = 3;
  return (mixture.array() - log_of_mean.array().exp()).max(0.0) / kAxes;
}

void MotionBank::MoveOrigin(const Eigen::Vector3d& origin) {
  for (Filter& filter : filters_) filter.head<3>() -= origin;
}

void MotionBank::TurnOrigin(const Eigen::Matrix3d& rotation) {
  for (Filter& filter : filters_) {
    filter.head<3>() = (rotation * filter.head<3>()).eval();
    Part(&filter, kXx) = (rotation * Part(filter, kXx) * rotation.transpose()).eval();
    for (const Entry block : {kXv, kXa}) {
      Part(&filter, block) = (rotation * Part(filter, block)).eval();
    }
  }
}

}  // namespace tagtwist::internal
