#include "frontend/base/statistics/chi_square.h"

#include <cmath>
#include <limits>

namespace tagtwist::internal {
namespace {

constexpr double kEpsilon = std::numeric_limits<double>::epsilon();

// x^a e^-x / Gamma(a), the factor that both expansions share.
double Prefactor(double a, double x) { return std::exp(a * std::log(x) - x - std::lgamma(a)); }

// P(a, x) = prefactor * sum of x^n / (a (a + 1) ... (a + n)); converges fast for x < a + 1.
double SeriesP(double a, double x) {
  double term = 1.0 / a, sum = term;
  for (int n = 1; term > kEpsilon * sum; ++n) {
    term *= x / (a + n);
    sum += term;
  }
  return sum * Prefactor(a, x);
}

// 1 - P(a, x) by the continued fraction of Abramowitz and Stegun, 6.5.31, in Lentz's form; for
// x >= a + 1.
double FractionQ(double a, double x) {
  constexpr double kTiny = 1e-300;
  double b = x + 1 - a, c = 1 / kTiny, d = 1 / b, fraction = d;
  for (int n = 1; n < 1'000'000; ++n) {
    const double an = -n * (n - a);
    b += 2;
    d = an * d + b;
    d = 1 / (std::abs(d) < kTiny ? kTiny : d);
    c = b + an / c;
    if (std::abs(c) < kTiny) c = kTiny;
    fraction *= c * d;
    if (std::abs(c * d - 1) < kEpsilon) break;
  }
  return fraction * Prefactor(a, x);
}

}  // namespace

double RegularisedGammaP(double a, double x) {
  if (!(x > 0)) return 0;
  return x < a + 1 ? SeriesP(a, x) : 1 - FractionQ(a, x);
}

double ChiSquareQuantile(double probability, double dof) {
  double low = 0, high = dof + 100;
  while (RegularisedGammaP(dof / 2, high / 2) < probability) high *= 2;
  while (high - low > 1e-10 * high) {
    const double middle = 0.5 * (low + high);
    (RegularisedGammaP(dof / 2, middle / 2) < probability ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

ChiSquareBand MeanChiSquareBand(double dof, size_t count, double probability) {
  const double n = static_cast<double>(count), tail = 0.5 * (1 - probability);
  return {ChiSquareQuantile(tail, n * dof) / n, ChiSquareQuantile(1 - tail, n * dof) / n};
}

}  // namespace tagtwist::internal
