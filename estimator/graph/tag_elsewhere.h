#pragma once
#include <Eigen/Core>

namespace tagtwist::internal {

/// A tag that is seen elsewhere than the map has it, by its own side at least.
struct TagElsewhere {
  int id = -1;
  Eigen::Vector2d shift_m = Eigen::Vector2d::Zero();  // of its centre, on the map's plane of it
  double size_m = 0;                                  // of its side
};

}  // namespace tagtwist::internal
