#pragma once
#include <Eigen/Core>
#include <cstddef>

namespace tagtwist::internal {

/// Where the entries of Kalman filters over [x; dx/dt; d2x/dt2] (3 entries each) lie: those of one
/// filter by itself, and of many entry by entry for four side by side.
struct FilterLayout {
  using State = Eigen::Matrix<double, 9, 1>;
  /// The mean, then the covariance's six blocks of the upper triangle, by columns (and one entry
  /// that is idle).
  using Filter = Eigen::Matrix<double, 64, 1>;
  /// First entries of the blocks.
  enum Block { kXx = 9, kXv = 18, kXa = 27, kVv = 36, kVa = 45, kAa = 54 };
  static constexpr Block kBlocks[3][3] = {{kXx, kXv, kXa}, {kXv, kVv, kVa}, {kXa, kVa, kAa}};
  /// Of the last update the innovation's whitened square, and the determinant of its covariance; a
  /// Filter has neither.
  static constexpr int kSquare = 63, kDeterminant = 64;
  static constexpr size_t kOfFilter = 63, kEntries = 65, kSide = 4;
};

}  // namespace tagtwist::internal
