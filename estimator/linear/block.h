#pragma once
#include <Eigen/Core>

namespace tagtwist {

/// Entries of the error state of a graph's state, see graph.h.
inline constexpr int kBlockSize = 18;
/// What the normal equations say of a pair of states.
using Block = Eigen::Matrix<double, kBlockSize, kBlockSize>;
/// One state's gradient or step.
using BlockVector = Eigen::Matrix<double, kBlockSize, 1>;

}  // namespace tagtwist
