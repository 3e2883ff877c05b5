#pragma once
#include <Eigen/Core>
#include <functional>

#include "tests/support/situations/phantoms.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal {

/// Where a body is that swings about a point of the mat and keeps looking at it.
std::function<Pose(double t)> OrbitAbout(const Eigen::Vector3d& centre, Rng* rng);

/// The same, of which only the tag is seen that most frames show; with `another`, for seven frames
/// of every 21 a second one, too.
SituationDraw WithLoneTag(SituationDraw draw, bool another);

}  // namespace tagtwist::internal
