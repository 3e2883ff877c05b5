#pragma once
#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <vector>

#include "frontend/pattern/pattern_state.h"

namespace tagtwist::internal {

/// Pixels of a tag's surroundings, in the order of the image's rows.
struct PatternPixels {
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();  // near the tag's centre [px]
  std::vector<float> x, y;  // [px] from the origin, without the lens's distortion
  std::vector<float> grey;  // 0 to 255

  size_t size() const { return grey.size(); }
  void Reserve(size_t n) {
    x.reserve(n);
    y.reserve(n);
    grey.reserve(n);
  }
  void Add(double x_px, double y_px, uint8_t grey_value) {
    x.push_back(static_cast<float>(x_px - origin.x()));
    y.push_back(static_cast<float>(y_px - origin.y()));
    grey.push_back(grey_value);
  }
};

/// Weighted sums over the pixels at one state, by Tukey's weights.
struct PatternSums {
  Eigen::Matrix<double, kPatternUnknowns, kPatternUnknowns> normal;  // sum w row row'
  PatternVector gradient;                                            // sum w row residual
  double weight = 0, psi2 = 0, d_psi = 0;                            // psi = w residual
  std::array<double, 2> lagged{};     // sum psi psi' over pixels one and two apart in a row
  std::array<double, 2> paired{};     // sum psi^2 over those that have such a pixel to the left
  size_t used = 0, contradicted = 0;  // contradicted: off by more than half the contrast
  double noise_grey = 0;  // robust standard deviation of the residuals, from their median
};

/// Every stride-th pixel. Residuals of `reach_grey` and more do not count.
PatternSums SumPattern(const PatternModel& model, const NormalTable& normal,
                       const PatternPixels& pixels, const PatternState& state, double reach_grey,
                       size_t stride);

}  // namespace tagtwist::internal
