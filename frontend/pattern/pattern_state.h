#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>

#include "frontend/pattern/pattern_model.h"

namespace tagtwist::internal {

/// What makes the picture of one tag. A pixel p = (x, y) sees
///   illumination * (black + gain * B(h t; h^2 J S J')),   t = tag_from_pixel(p),  J = dt/dp,
/// with B the blurred pattern (PatternModel, coordinates in cells), h half the square's side in
/// cells, S the blur in the image and illumination = 1 + l1 dx + l2 dy + l3 (dx^2 + dy^2),
/// (dx, dy) = (p - origin) / radius: a gradient, and what a lens darkens towards its border.
struct PatternState {
  /// Homography (3x3) from pixels to the tag: the square's corners are (+-1, +-1), v down.
  Eigen::Matrix3d tag_from_pixel = Eigen::Matrix3d::Identity();
  Eigen::Vector3d blur_px2{0.4, 0, 0.4};            // covariance S: xx, xy, yy [px^2]
  double black = 0, gain = 0;                       // [grey]
  Eigen::Vector3d light = Eigen::Vector3d::Zero();  // l1, l2, l3
  Eigen::Vector2d origin = Eigen::Vector2d::Zero();
  double radius_px = 1;
};

/// How a tag looked when it was fitted: what a next fit starts from.
struct PatternLook {
  Eigen::Vector3d blur_px2, light;             // as in PatternState
  double black = 0, gain = 0, noise_grey = 0;  // noise: standard deviation of the residuals
};

/// Order of the unknowns: d (8), blur (3), black, gain, light (3). d moves the tag coordinates by
///   du = d1 u + d2 v + d3 - u (d7 u + d8 v),  dv = d4 u + d5 v + d6 - v (d7 u + d8 v).
constexpr int kPatternUnknowns = 16;
using PatternVector = Eigen::Matrix<double, kPatternUnknowns, 1>;
using PatternRow = std::array<double, kPatternUnknowns>;

/// The homography from the pixels of a convex quad p1..p4 (bottom-left, bottom-right, top-right,
/// top-left as printed) to the square; nullopt where there is none.
std::optional<Eigen::Matrix3d> TagFromPixel(const std::array<Eigen::Vector2d, 4>& corners);

/// Pixels of p1..p4 [px], and, where asked for, their derivative by d (8x8, u1 v1 .. u4 v4).
std::array<Eigen::Vector2d, 4> PatternCorners(const PatternState& state,
                                              Eigen::Matrix<double, 8, 8>* d_corners = nullptr);

/// Grey of a pixel and its derivative by the unknowns, the effect of d on J and so on the blur over
/// the tag included. What a correlated blur adds to the derivative by the blur is left out.
double PredictGrey(const PatternModel& model, const PatternState& state, const NormalTable& normal,
                   const Eigen::Vector2d& pixel, PatternRow* row);

/// The state moved by a step of the unknowns; the blur is kept between a sharp pixel's and a wide
/// one's.
PatternState Move(const PatternState& state, const PatternVector& step);

}  // namespace tagtwist::internal
