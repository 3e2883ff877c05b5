#include "estimator/motion/bank/interval_classes.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tagtwist::internal {
namespace {

// A class is never ruled out.
constexpr double kLeastClassWeight = 1e-30;

using Class = MotionBank::Class;

// Logarithm of the density, but for a constant, that what two classes say of the first `Rows`
// entries is the same. Their variances may differ by many orders of magnitude.
template <int Rows>
double LogOfMeeting(const Class& a, const Class& b) {
  using Square = Eigen::Matrix<double, Rows, Rows>;
  using Column = Eigen::Matrix<double, Rows, 1>;
  const MotionBank::Filter sum = a.filter + b.filter;
  const Square covariance = MotionBank::CovarianceOf(sum).topLeftCorner<Rows, Rows>();
  const Column inverse = covariance.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::LLT<Square> llt(inverse.asDiagonal() * covariance * inverse.asDiagonal());
  if (llt.info() != Eigen::Success) return -std::numeric_limits<double>::infinity();
  const Column d = a.filter.head<Rows>() - b.filter.head<Rows>();
  const Column whitened = llt.matrixL().solve(inverse.asDiagonal() * d);
  return -0.5 * whitened.squaredNorm() + inverse.array().log().sum() -
         llt.matrixLLT().diagonal().array().log().sum();
}

double LogOfMeeting(WhiteNoiseOn on, const Class& a, const Class& b) {
  // An idle acceleration says nothing.
  return on == WhiteNoiseOn::kJerk ? LogOfMeeting<9>(a, b) : LogOfMeeting<6>(a, b);
}

double LogOfSum(double a, double b) {
  const double most = std::max(a, b);
  return std::isfinite(most) ? most + std::log1p(std::exp(std::min(a, b) - most)) : most;
}

}  // namespace

std::vector<Class> InForwardTime(std::vector<Class> backwards, const Eigen::Vector3d& origin) {
  for (Class& c : backwards) MotionBank::TurnTime(origin, &c.filter);
  return backwards;
}

std::vector<double> WeightsFromBothSides(const std::vector<Class>& past,
                                         const std::vector<Class>& future, WhiteNoiseOn on,
                                         double keep, size_t n) {
  // Beyond this below the likeliest one so far, livelier classes are so, too.
  constexpr double kExcluded = 25;
  std::vector<double> out(n, kLeastClassWeight);
  const auto likeliest =
      std::max_element(future.begin(), future.end(),
                       [](const Class& a, const Class& b) { return a.weight < b.weight; });
  const double change = std::log((1 - keep) / static_cast<double>(n) * likeliest->weight);
  std::vector<double> logs(past.size(), -std::numeric_limits<double>::infinity());
  double most = logs[0];
  for (size_t i = 0; i < past.size(); ++i) {
    const Class& c = past[i];
    double log = change + LogOfMeeting(on, c, *likeliest);
    const auto same = std::find_if(future.begin(), future.end(),
                                   [&](const Class& d) { return d.index == c.index; });
    if (same != future.end()) {
      log = LogOfSum(log, std::log(keep * same->weight) + LogOfMeeting(on, c, *same));
    }
    logs[i] = std::log(c.weight) + log;
    most = std::max(most, logs[i]);
    if (c.index > likeliest->index && logs[i] < most - kExcluded) break;
  }
  if (!std::isfinite(most)) {  // what no number holds
    for (const Class& c : past) out[c.index] = c.weight;
    return out;
  }
  double sum = 0;
  for (const double log : logs) sum += std::exp(log - most);
  for (size_t i = 0; i < past.size(); ++i) out[past[i].index] += std::exp(logs[i] - most) / sum;
  return out;
}

}  // namespace tagtwist::internal
