#pragma once
#include <Eigen/Core>
#include <optional>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/trajectory.h"
#include "estimator/result/systematic_share.h"
#include "estimator/systematic/map_field.h"
#include "estimator/systematic/systematic_basis.h"

namespace tagtwist::internal {

/// Errors of lens, map and corners that last over a recording, as its residuals show them. They are
/// not averaged away over frames as noise is.
struct SystematicErrors {
  double field_sigma_px = 0;  // of each coordinate anywhere in the image; 0: none was seen
  double tag_sigma_m = 0;     // of each coordinate of a tag's position
  double bias_sigma_px = 0;   // of corners along their tags' diagonals
  double map_sigma_m = 0;     // of each coordinate of a tag's position, shared by its neighbours
  double mount_sigma_rad = 0, mount_sigma_m = 0;  // of the cameras after a rig's first
  double noise_scale = 1;                         // what is left of the corners' noise, as a factor
  /// Parameters of the basis x k: E[x x'] = root root', but for what hardly moves a state.
  Eigen::MatrixXd root;
  std::optional<MapField> map;  // where neighbouring tags share some, and
  Eigen::MatrixXd map_root;     // the same columns of its modes (OfTag)

  bool None() const { return root.cols() == 0; }
};

/// From frames at their solution, each pose left open: what residuals have in common at a place of
/// the image, at a tag, along the diagonals. Second moments about zero, the mean included, for the
/// estimate stays as it is. Takes at most 500 frames, spread; time O(frames * size^2 + size^3).
SystematicErrors LearnSystematicErrors(const SystematicBasis& basis, const NoiseModel& noise,
                                       const std::vector<GraphFrame>& frames);

/// What these errors do to the states of a solved graph: their covariance, of each state and
/// between neighbours, is added to the trajectory's and to `covariances` (one a state). The frames
/// are the graph's. Nothing where the normal equations cannot be solved.
SystematicShare AddSystematicErrors(const SystematicBasis& basis, const SystematicErrors& errors,
                                    const NoiseModel& noise, const Graph& graph,
                                    const std::vector<GraphFrame>& frames, Trajectory* trajectory,
                                    std::vector<StateCovariance>* covariances);

}  // namespace tagtwist::internal
