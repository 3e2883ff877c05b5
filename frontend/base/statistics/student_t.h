#pragma once

namespace tagtwist::internal {

/// Regularised incomplete beta function I_x(a, b), a, b > 0, x in [0, 1]; relative error below
/// 1e-10 (continued fraction: Abramowitz and Stegun, 26.5.8).
double RegularisedBeta(double x, double a, double b);

/// The probability that Student's t of `dof` > 0 degrees of freedom lies further from 0 than `t`,
/// either way.
double StudentTwoSided(double t, double dof);

/// The value that |t| stays below with `probability` in (0, 1).
double StudentBand(double probability, double dof);

}  // namespace tagtwist::internal
