#pragma once
#include <Eigen/Core>
#include <vector>

#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Errors of a map that neighbouring tags share, to first order, as the sum of modes of unit
/// variance, each of which moves the tags by about 1 m (root mean square):
///   - how it is bent: each coordinate a Gaussian process over the places (Matern 5/2; Rasmussen
///   and
///     Williams 2006, Eq. 4.17) without what shifts, turns and stretches all of them, and a shift
///     and a turn of all, which no residual shows, as large as such a process has them, at most as
///     large as the bend;
///   - how it is stretched along the axes that it has, and a shift: nobody knows from where.
class MapField {
 public:
  /// Of tags at those places, not all of them one [m].
  MapField(std::vector<Eigen::Vector3d> places, double length_m);

  double length_m() const { return length_m_; }
  int bend_modes() const { return static_cast<int>(3 * by_place_.cols() + 6); }
  int stretch_modes() const { return static_cast<int>(stretches_.size()) + 3; }
  int modes() const { return bend_modes() + stretch_modes(); }
  /// What each mode does to a tag, 5 x modes: the shift of its place [m], and the slopes along its
  /// own x and y by which its paper, which follows, is turned.
  Eigen::MatrixXd OfTag(const Tag& tag) const;

 private:
  // A displacement that is linear in the place: factor * (place - centre) is what it adds.
  using Linear = Eigen::Matrix3d;
  // The modes of one coordinate at a place (first row), and their derivatives there.
  Eigen::MatrixXd BendAt(const Eigen::Vector3d& place) const;
  void MakeLinear(double rigid);

  std::vector<Eigen::Vector3d> places_;
  double length_m_;
  Eigen::Vector3d centre_;
  Eigen::MatrixXd by_place_;  // places x modes: covariances with the places times it, less
  Eigen::MatrixXd linear_;    // what is linear in the place (4 x modes, the constant first)
  double shift_ = 1;          // of the bend's shifts
  std::vector<Linear> turns_, stretches_;
};

/// What a unit of those slopes moves the corners of a tag by, 3 x 2 a corner [m], one below
/// another.
Eigen::Matrix<double, 12, 2> CornersBySlopes(const Tag& tag);

}  // namespace tagtwist::internal
