#include "frontend/base/statistics/student_t.h"

#include <cmath>

namespace tagtwist::internal {
namespace {

// The continued fraction of I_x(a, b) by the modified Lentz method, for x below its mean.
double BetaFraction(double x, double a, double b) {
  constexpr int kMostTerms = 500;
  constexpr double kTiny = 1e-300, kEnough = 1e-15;
  const auto away_from_zero = [](double value) { return std::abs(value) < kTiny ? kTiny : value; };
  double c = 1, d = 1 / away_from_zero(1 - (a + b) * x / (a + 1)), out = d;
  for (int m = 1; m <= kMostTerms; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1 / away_from_zero(1 + even * d);
    c = away_from_zero(1 + even / c);
    out *= c * d;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1 / away_from_zero(1 + odd * d);
    c = away_from_zero(1 + odd / c);
    out *= c * d;
    if (std::abs(c * d - 1) < kEnough) break;
  }
  return out;
}

}  // namespace

double RegularisedBeta(double x, double a, double b) {
  if (!(x > 0)) return 0;
  if (x >= 1) return 1;
  const double log_front =
      std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b) + a * std::log(x) + b * std::log1p(-x);
  const double front = std::exp(log_front);
  if (x < (a + 1) / (a + b + 2)) return front * BetaFraction(x, a, b) / a;
  return 1 - front * BetaFraction(1 - x, b, a) / b;
}

double StudentTwoSided(double t, double dof) {
  return RegularisedBeta(dof / (dof + t * t), dof / 2, 0.5);
}

double StudentBand(double probability, double dof) {
  double low = 0, high = 1;
  while (1 - StudentTwoSided(high, dof) < probability && high < 1e300) high *= 2;
  for (int i = 0; i < 200 && high - low > 1e-13 * high; ++i) {
    const double middle = 0.5 * (low + high);
    (1 - StudentTwoSided(middle, dof) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

}  // namespace tagtwist::internal
