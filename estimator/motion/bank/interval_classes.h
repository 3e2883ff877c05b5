#pragma once
#include <vector>

#include "estimator/motion/bank/motion_bank.h"

namespace tagtwist::internal {

/// Classes of a bank that came from the future and ran backwards in time, in forward time; its x
/// begins at `origin`, as the bank from the past measures x.
std::vector<MotionBank::Class> InForwardTime(std::vector<MotionBank::Class> backwards,
                                             const Eigen::Vector3d& origin);

/// Weights of all `n` classes over the interval that ends with a frame: of each class of the past,
/// predicted to the frame, by how well what it says meets what is said by the classes of the future
/// that have measured it, the same class and the likeliest one:
///
///   w_c ~ p_c (keep b_c N(m_c - m'_c; P_c + P'_c) + (1 - keep) / n b_* N(m_c - m'_*; P_c + P'_*)).
///
/// A jump of the acceleration counts in the interval in which it was, though frames show it only
/// later, from either side. Classes in order of their index.
std::vector<double> WeightsFromBothSides(const std::vector<MotionBank::Class>& past,
                                         const std::vector<MotionBank::Class>& future,
                                         WhiteNoiseOn on, double keep, size_t n);

}  // namespace tagtwist::internal
