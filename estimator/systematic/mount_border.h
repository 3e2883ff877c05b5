#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/systematic/systematic_basis.h"
#include "estimator/systematic/systematic_errors.h"

namespace tagtwist::internal {

/// How far mounts and clocks of the cameras after a rig's first may be from where they are,
/// standard deviations; 0 holds them.
struct MountPriors {
  double rotation_rad = 0, position_m = 0, clock_s = 0;
};

/// What a solved graph says of them, the states eliminated.
struct MountBorder {
  /// Seven a camera: turn(3) [rad] and shift(3) [m] of its mount, and what its clock offset grows
  /// by [s]. The mount that the data want is cam_from_body * (Exp(turn), shift), cam_from_world
  /// likewise of one that stands.
  static constexpr int kEntries = 7;
  Eigen::VectorXd step;
  Eigen::MatrixXd covariance;

  /// The longest step of an entry, in its standard deviations.
  double StepInSigmas() const;
};

/// `frames` are the graph's, and mounts are right in the basis. The step is that without errors of
/// lens, map and corners, and what these do to it, of the size of `errors`, is in the covariance;
/// the first camera says where the body is and what time it is. nullopt where the normal equations
/// are not positive definite.
std::optional<MountBorder> MakeMountBorder(const SystematicBasis& basis,
                                           const SystematicErrors& errors,
                                           const MountPriors& priors, int n_cameras,
                                           const NoiseModel& noise, const Graph& graph,
                                           const std::vector<GraphFrame>& frames);

}  // namespace tagtwist::internal
