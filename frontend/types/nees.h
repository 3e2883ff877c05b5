#pragma once
#include <Eigen/Cholesky>
#include <array>
#include <cmath>
#include <optional>

#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// Normalised estimation error squared, e' P^-1 e (Bar-Shalom, Li and Kirubarajan: Estimation with
/// Applications to Tracking and Navigation, 2001), of parts of the error state: each part is three
/// entries from the given one on. e = Difference(truth, estimate), so that truth = estimate [+] e:
/// P is the covariance in the estimate's own tangent. It has 3 * kParts degrees of freedom. nullopt
/// where P is not positive definite or anything is not finite.
template <size_t kParts>
std::optional<double> Nees(const BodyState& truth, const BodyState& estimate,
                           const StateCovariance& covariance,
                           const std::array<int, kParts>& first_entries) {
  constexpr int kSize = 3 * static_cast<int>(kParts);
  const StateVector error = Difference(truth, estimate);
  Eigen::Matrix<double, kSize, 1> e;
  Eigen::Matrix<double, kSize, kSize> p;
  for (int i = 0; i < kSize; ++i) {
    const auto entry = [&](int k) { return first_entries[static_cast<size_t>(k / 3)] + k % 3; };
    e(i) = error(entry(i));
    for (int k = 0; k < kSize; ++k) p(i, k) = covariance(entry(i), entry(k));
  }
  const Eigen::LLT<Eigen::Matrix<double, kSize, kSize>> llt(p);
  if (llt.info() != Eigen::Success) return std::nullopt;
  const double value = e.dot(llt.solve(e));
  if (!std::isfinite(value)) return std::nullopt;
  return value;
}

/// The whole error state, the pose and the twist alone, and the position, for Nees.
constexpr std::array<int, 4> kWholeState = {0, 3, 6, 9};
constexpr std::array<int, 2> kPoseEntries = {0, 3}, kTwistEntries = {6, 9};
constexpr std::array<int, 1> kPositionEntries = {3};

}  // namespace tagtwist::internal
