#pragma once
#include <Eigen/Core>
#include <vector>

#include "frontend/normal_table.h"
#include "frontend/tag_family.h"

namespace tagtwist {

/// Covariance of a blur over the tag [cells^2].
struct CellBlur {
  double uu = 0, uv = 0, vv = 0;
};

/// The whiteness of a blurred pattern at a point, and its derivatives by the point [1/cell].
struct PatternSample {
  double value = 0;  // 0 black, 1 white
  double u = 0, v = 0, uu = 0, uv = 0, vv = 0;
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

  PatternSample At(double u, double v, const CellBlur& blur, const NormalTable& normal) const;

  /// Half the side of the square whose corners are p1..p4, and of the whole pattern [cells].
  double square_half() const { return square_half_; }
  double pattern_half() const { return 0.5 * cells_; }

 private:
  int cells_ = 0;
  double square_half_ = 0;
  std::vector<double> white_;  // cells x cells, row by row
};

}  // namespace tagtwist
