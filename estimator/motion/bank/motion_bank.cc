#include "estimator/motion/bank/motion_bank.h"

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

Eigen::Map<Eigen::Matrix3d> Part(MotionBank::Filter* filter, int block) {
  return Eigen::Map<Eigen::Matrix3d>(filter->data() + block);
}

Eigen::Map<const Eigen::Matrix3d> Part(const MotionBank::Filter& filter, int block) {
  return Eigen::Map<const Eigen::Matrix3d>(filter.data() + block);
}

// Nothing is known of x.
MotionBank::Filter Fresh(const MotionBankOptions& options) {
  constexpr double kAnywhere = 1e3;  // m, or rad
  const bool has_acceleration = options.on == WhiteNoiseOn::kJerk;
  const double a = has_acceleration ? options.first_acceleration_sigma : 0;
  MotionBank::Filter out = MotionBank::Filter::Zero();
  Part(&out, ClassFilters::kXx).diagonal().setConstant(kAnywhere * kAnywhere);
  Part(&out, ClassFilters::kVv).diagonal().setConstant(std::pow(options.first_rate_sigma, 2));
  Part(&out, ClassFilters::kAa).diagonal().setConstant(a * a);
  return out;
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

MotionBank::MotionBank(const MotionBankOptions& options)
    : options_(options),
      weights_(static_cast<size_t>(options.classes), 1.0 / options.classes),
      filters_(weights_.size(), Fresh(options)) {
  for (int i = 0; i < options.classes; ++i) {
    densities_.push_back(options.least_density * std::pow(options.ratio, i));
  }
}

// Each class takes over from those that may switch to it.
void MotionBank::Mix(double dt_s) {
  const size_t n = weights_.size();
  if (n < 2) return;
  const double stay = std::exp(-dt_s / options_.switch_s);
  std::vector<double> leaves(n);  // weight that goes to each class that may follow
  for (size_t i = 0; i < n; ++i) {
    const double others = static_cast<double>(n - 1 - i) + (i > 0 ? 1 : 0);
    leaves[i] = (1 - stay) * weights_[i] / others;
  }
  filters_.Mix(stay, leaves, Mean(), &weights_);
  Normalise(&weights_);
}

void MotionBank::Predict(double dt_s) {
  Mix(dt_s);
  Eigen::Matrix3d q = ProcessCovariance({options_.on, 1.0, false, options_.shake_s}, dt_s);
  if (options_.on == WhiteNoiseOn::kAcceleration) q(2, 2) = 0;  // the idle acceleration
  filters_.Predict(Transition(options_.on, dt_s), q, densities_);
}

void MotionBank::Measure(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance) {
  filters_.Update(x, covariance);
  for (size_t i = 0; i < size(); ++i) {               // from weights to their logarithms
    if (!std::isfinite(filters_.LogLikelihood(i))) {  // what no number holds any more
      filters_.Set(i, Fresh(options_));
      filters_.UpdateOne(i, x, covariance);
    }
    weights_[i] = std::log(weights_[i]) + filters_.LogLikelihood(i);
  }
  const double most = *std::max_element(weights_.begin(), weights_.end());
  double sum = 0;
  for (double& weight : weights_) {
    weight = std::exp(weight - most);
    sum += weight;
    weight = std::max(weight, kLeastWeight);
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

MotionBank::Covariance MotionBank::MixtureCovariance() const {
  const State mean = Mean();
  Covariance out = Covariance::Zero();
  for (size_t i = 0; i < size(); ++i) {
    const Filter filter = filters_.Of(i);
    const State apart = filter.head<9>() - mean;
    out += weights_[i] * (CovarianceOf(filter) + apart * apart.transpose());
  }
  return out;
}

MotionBank::Covariance MotionBank::CovarianceOf(const Filter& filter) {
  Covariance out;
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      const auto block = Part(filter, ClassFilters::kBlocks[i][j]);
      out.block<3, 3>(3 * i, 3 * j) = block;
      out.block<3, 3>(3 * j, 3 * i) = block.transpose();
    }
  }
  return out;
}

void MotionBank::TurnTime(const Eigen::Vector3d& origin, Filter* filter) {
  filter->head<3>() += origin;
  filter->segment<3>(3) *= -1;
  for (const int block : {ClassFilters::kXv, ClassFilters::kVa}) Part(filter, block) *= -1;
}

std::vector<MotionBank::Class> MotionBank::Classes(double least_weight) const {
  std::vector<Class> out;
  out.reserve(size());
  for (size_t i = 0; i < size(); ++i) {
    if (weights_[i] >= least_weight) {
      out.push_back({i, densities_[i], weights_[i], filters_.Of(i)});
    }
  }
  return out;
}

Eigen::Vector2d MotionBank::ExcessVariance() const {
  const State mean = Mean();
  Eigen::Vector2d mixture = Eigen::Vector2d::Zero(), log_of_mean = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < size(); ++i) {
    const Filter filter = filters_.Of(i);
    for (int part = 0; part < 2; ++part) {
      const double own = Part(filter, ClassFilters::kBlocks[part][part]).trace();
      const double apart = (filter.head<9>() - mean).segment<3>(3 * part).squaredNorm();
      mixture(part) += weights_[i] * (own + apart);
      log_of_mean(part) += weights_[i] * std::log(own);  // a variance goes with a density's power
    }
  }
  constexpr int kAxes = 3;
  return (mixture.array() - log_of_mean.array().exp()).max(0.0) / kAxes;
}

void MotionBank::MoveOrigin(const Eigen::Vector3d& origin) {
  State by = State::Zero();
  by.head<3>() = -origin;
  filters_.Move(by);
}

}  // namespace tagtwist::internal
