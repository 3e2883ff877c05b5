#pragma once
#include <Eigen/Core>
#include <array>
#include <optional>

#include "frontend/types/camera.h"

namespace tagtwist::internal {

/// How four corners run in the image, rows counted downwards. A tag seen from its front, by
/// whatever camera and lens, has p1..p4 anticlockwise.
enum class QuadTurn {
  kAnticlockwise,
  kClockwise,
  kFlat,  // so flat that noise may have turned it
  kNone   // not convex, or not finite
};
QuadTurn TurnOf(const std::array<Eigen::Vector2d, 4>& corners);

/// Distance [px] of four corners from the nearest projection of a square: the root of the smallest
/// sum over the corners of |predicted - seen|^2 that any pose and any size give it. Of its square,
/// divided by the variance of a coordinate, two degrees of freedom are left by the corners' eight.
/// Infinite where no pose comes near; nullopt where the lens has no ray for a corner.
std::optional<double> SquareMisfitPx(const std::array<Eigen::Vector2d, 4>& corners,
                                     const Camera& camera);

/// The same to first order in the corners' errors, without a search (Sampson's distance from what
/// makes the homography's first two columns equally long and square to each other). Near the truth
/// for small misfits; large ones it says within a factor of some.
std::optional<double> ApproximateSquareMisfitPx(const std::array<Eigen::Vector2d, 4>& corners,
                                                const Camera& camera);

}  // namespace tagtwist::internal
