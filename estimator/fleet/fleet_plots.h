#pragma once
#include <string>
#include <vector>

namespace tagtwist::internal {

/// A point of a ScatterSvg; a click leads to the row. Points that are not positive are left out.
struct ScatterPoint {
  size_t row = 0;
  double x = 0, y = 0;
  std::string title;  // told when it is pointed at
};

/// A small plot with logarithmic axes, as SVG: needs no script, and prints. `diagonal`: the line
/// x = y is drawn, too. Empty where fewer than two points can be drawn.
std::string ScatterSvg(const std::vector<ScatterPoint>& points, const std::string& x_title,
                       const std::string& y_title, bool diagonal);

}  // namespace tagtwist::internal
