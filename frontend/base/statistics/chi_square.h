#pragma once
#include <cstddef>

namespace tagtwist::internal {

/// Regularised lower incomplete gamma function P(a, x), a > 0, x >= 0: the probability that a
/// chi-square variable of 2 a degrees of freedom lies below 2 x.
double RegularisedGammaP(double a, double x);

/// The value that a chi-square variable of `dof` > 0 degrees of freedom stays below with
/// probability in (0, 1); relative error below 1e-9.
double ChiSquareQuantile(double probability, double dof);

/// Interval that holds the mean of `count` independent chi-square variables of `dof` degrees of
/// freedom with the given probability.
struct ChiSquareBand {
  double low = 0, high = 0;
};
ChiSquareBand MeanChiSquareBand(double dof, size_t count, double probability = 0.95);

}  // namespace tagtwist::internal
