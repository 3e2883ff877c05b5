#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

#include "frontend/pattern/normal_table.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal {

/// Covariance of a blur over the tag [cells^2].
struct CellBlur {
  double uu = 0, uv = 0, vv = 0;
};

/// The whiteness of a blurred pattern at a point, and its derivatives by the point [1/cell].
/// A number, or an Eigen array of them for many points.
template <typename S>
struct PatternSample {
  S value;  // 0 black, 1 white
  S u, v, uu, uv, vv;
};

/// A tag's printed pattern under a Gaussian blur. Coordinates in cells: (0, 0) is the centre of the
/// tag, u to the right and v down as printed; beyond the pattern its outermost cells go on.
///
/// Without correlation between u and v the blurred pattern is a sum over cells of products of two
/// differences of normal distributions. The correlation c = blur.uv enters by the heat equation
/// d value / d c = d2 value / du dv, to second order.
class PatternModel {
 public:
  explicit PatternModel(const TagPattern& pattern);

  PatternSample<double> At(double u, double v, const CellBlur& blur,
                           const NormalTable& normal) const;

  /// The whiteness of the cell of a point and how the eight around it differ, for a blur that does
  /// not reach beyond them: with the shares L, R, T, B of what a point sees left, right, above and
  /// below its cell, its whiteness is
  ///   c[0] + L c[1] + R c[2] + T (c[3] + L c[4] + R c[5]) + B (c[6] + L c[7] + R c[8]).
  const std::array<float, 9>& Around(int column, int row) const {
    return around_[static_cast<size_t>(row * cells_ + column)];
  }

  int cells() const { return cells_; }  // along the whole pattern
  /// Half the side of the square whose corners are p1..p4, and of the whole pattern [cells].
  double square_half() const { return square_half_; }
  double pattern_half() const { return 0.5 * cells_; }

 private:
  int cells_ = 0;
  double square_half_ = 0;
  std::vector<double> white_;                 // cells x cells, row by row
  std::vector<std::array<float, 9>> around_;  // of each cell, row by row
};

}  // namespace tagtwist::internal
