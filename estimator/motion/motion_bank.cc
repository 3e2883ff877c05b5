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

// F P F' + Q, F and Q those of an axis, for all three alike.
MotionBank::Covariance Predicted(const MotionBank::Covariance& p, const Eigen::Matrix3d& f,
                                 const Eigen::Matrix3d& q) {
  MotionBank::Covariance half, out;
  for (int i = 0; i < 3; ++i) {
    auto rows = half.middleRows<3>(3 * i);
    rows = f(i, 0) * p.middleRows<3>(0);
    for (int j = 1; j < 3; ++j) rows += f(i, j) * p.middleRows<3>(3 * j);
  }
  for (int i = 0; i < 3; ++i) {
    auto columns = out.middleCols<3>(3 * i);
    columns = f(i, 0) * half.middleCols<3>(0);
    for (int j = 1; j < 3; ++j) columns += f(i, j) * half.middleCols<3>(3 * j);
    for (int j = 0; j < 3; ++j) out.block<3, 3>(3 * j, 3 * i).diagonal().array() += q(j, i);
  }
  return out;
}

MotionBank::State Predicted(const MotionBank::State& x, const Eigen::Matrix3d& f) {
  MotionBank::State out;
  for (int i = 0; i < 3; ++i) {
    out.segment<3>(3 * i) =
        f(i, 0) * x.segment<3>(0) + f(i, 1) * x.segment<3>(3) + f(i, 2) * x.segment<3>(6);
  }
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

MotionBank::MotionBank(const MotionBankOptions& options) : options_(options) {
  const auto n = static_cast<size_t>(options.classes);
  weights_.assign(n, 1.0 / options.classes);
  filters_.resize(n);
  const bool has_acceleration = options.on == WhiteNoiseOn::kJerk;
  for (int i = 0; i < options.classes; ++i) {
    densities_.push_back(options.least_density * std::pow(options.ratio, i));
    Covariance& p = filters_[static_cast<size_t>(i)].covariance;
    constexpr double kAnywhere = 1e3;  // m, or rad: nothing is known of x
    p.diagonal().segment<3>(0).setConstant(kAnywhere * kAnywhere);
    p.diagonal().segment<3>(3).setConstant(std::pow(options.first_rate_sigma, 2));
    const double a = has_acceleration ? options.first_acceleration_sigma : 0;
    p.diagonal().segment<3>(6).setConstant(a * a);
  }
}

// Each class takes over from those that may switch to it. Sums over all lower classes grow from one
// class to the next, so that the work is linear in the number of classes.
void MotionBank::Mix(double dt_s) {
  const size_t n = filters_.size();
  if (n < 2) return;
  const double stay = std::exp(-dt_s / options_.switch_s);
  const State centre = Mean();
  std::vector<Filter> moments(n);  // first and second moment about the centre
  std::vector<double> leaves(n);   // weight that goes to each class that may follow
  for (size_t i = 0; i < n; ++i) {
    moments[i].mean = filters_[i].mean - centre;
    moments[i].covariance = filters_[i].covariance;
    moments[i].covariance.noalias() += moments[i].mean.lazyProduct(moments[i].mean.transpose());
    const double others = static_cast<double>(n - 1 - i) + (i > 0 ? 1 : 0);
    leaves[i] = (1 - stay) * weights_[i] / others;
  }
  double lower = 0;
  Filter of_lower;
  for (size_t j = 0; j < n; ++j) {
    const double stays = stay * weights_[j], above = j + 1 < n ? leaves[j + 1] : 0;
    const double weight = stays + lower + above + kLeastWeight;
    State mean = stays * moments[j].mean + of_lower.mean;
    Covariance second = stays * moments[j].covariance + of_lower.covariance;
    if (above > 0) {
      mean += above * moments[j + 1].mean;
      second += above * moments[j + 1].covariance;
    }
    lower += leaves[j];
    of_lower.mean += leaves[j] * moments[j].mean;
    of_lower.covariance += leaves[j] * moments[j].covariance;
    mean /= weight;
    filters_[j].mean = centre + mean;
    filters_[j].covariance = second / weight;
    filters_[j].covariance.noalias() -= mean.lazyProduct(mean.transpose());
    weights_[j] = weight;
  }
  Normalise(&weights_);
}

void MotionBank::Predict(double dt_s) {
  Mix(dt_s);
  const Eigen::Matrix3d f = Transition(options_.on, dt_s);
  Eigen::Matrix3d q = ProcessCovariance({options_.on, 1.0}, dt_s);
  if (options_.on == WhiteNoiseOn::kAcceleration) q(2, 2) = 0;  // the idle acceleration
  for (size_t i = 0; i < filters_.size(); ++i) {
    filters_[i].mean = Predicted(filters_[i].mean, f);
    filters_[i].covariance = Predicted(filters_[i].covariance, f, densities_[i] * q);
  }
}

void MotionBank::Measure(const Eigen::Vector3d& x, const Eigen::Matrix3d& covariance) {
  std::vector<double> logs(filters_.size());
  for (size_t i = 0; i < filters_.size(); ++i) {
    State& m = filters_[i].mean;
    Covariance& p = filters_[i].covariance;
    const Eigen::Vector3d error = x - m.head<3>();
    const Eigen::Matrix3d s = p.topLeftCorner<3, 3>() + covariance;
    const Eigen::LLT<Eigen::Matrix3d> llt(s);
    const Eigen::Vector3d whitened = llt.matrixL().solve(error);
    logs[i] = std::log(weights_[i]) - 0.5 * whitened.squaredNorm() -
              Eigen::Matrix3d(llt.matrixL()).diagonal().array().log().sum();
    const Eigen::Matrix<double, 9, 3> gain = llt.solve(p.topRows<3>()).transpose();
    m.noalias() += gain.lazyProduct(error);
    // Joseph's form: after a long gap the prediction is no help, and a difference of equals.
    Covariance kept = p;
    kept.noalias() -= gain.lazyProduct(p.topRows<3>());
    p = kept;
    p.noalias() -= kept.leftCols<3>().lazyProduct(gain.transpose());
    p.noalias() += gain.lazyProduct(covariance).lazyProduct(gain.transpose());
    p = (0.5 * (p + p.transpose())).eval();
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
  for (size_t i = 0; i < filters_.size(); ++i) out += weights_[i] * filters_[i].mean;
  return out;
}

MotionBank::Covariance MotionBank::MixtureCovariance() const {
  const State mean = Mean();
  Covariance out = Covariance::Zero();
  for (size_t i = 0; i < filters_.size(); ++i) {
    const State d = filters_[i].mean - mean;
    out += weights_[i] * (filters_[i].covariance + d * d.transpose());
  }
  return out;
}

Eigen::Vector2d MotionBank::ExcessVariance() const {
  const State mean = Mean();
  Eigen::Vector2d mixture = Eigen::Vector2d::Zero(), log_of_mean = Eigen::Vector2d::Zero();
  for (size_t i = 0; i < filters_.size(); ++i) {
    for (int part = 0; part < 2; ++part) {
      const double own = filters_[i].covariance.diagonal().segment<3>(3 * part).sum();
      const double apart = (filters_[i].mean - mean).segment<3>(3 * part).squaredNorm();
      mixture(part) += weights_[i] * (own + apart);
      log_of_mean(part) += weights_[i] * std::log(own);  // a variance goes with a density's power
    }
  }
  constexpr int kAxes = 3;
  return (mixture.array() - log_of_mean.array().exp()).max(0.0) / kAxes;
}

void MotionBank::MoveOrigin(const Eigen::Matrix3d& rotation, const Eigen::Vector3d& origin) {
  for (Filter& filter : filters_) {
    filter.mean.head<3>() = rotation * filter.mean.head<3>() - origin;
    filter.covariance.topRows<3>() = (rotation * filter.covariance.topRows<3>()).eval();
    filter.covariance.leftCols<3>() =
        (filter.covariance.leftCols<3>() * rotation.transpose()).eval();
  }
}

std::vector<double> WeightsFromBothSides(const std::vector<double>& forwards,
                                         const std::vector<double>& before,
                                         const std::vector<double>& backwards) {
  std::vector<double> out;
  const double uniform = 1 / static_cast<double>(forwards.size());
  for (size_t i = 0; i < forwards.size(); ++i) {
    out.push_back(forwards[i] * backwards[i] / (before[i] + uniform) + kLeastWeight);
  }
  Normalise(&out);
  return out;
}

}  // namespace tagtwist::internal
