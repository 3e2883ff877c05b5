#pragma once
#include <optional>

#include "estimator/graph/graph.h"
#include "estimator/linear/block_banded.h"
#include "estimator/solve/ceres_solver.h"

namespace tagtwist {

/// Decrease of the cost, half a square of standard deviations, that is none.
inline constexpr double kNoDecrease = 1e-14;

/// What SolveBanded found.
struct BandedSolution {
  SolveSummary summary;
  std::optional<BlockBandedCholesky> normal_equations;  // at the solution; where usable
};

/// Whether SolveBanded can do it: no tracked point in the graph.
bool IsBanded(const Graph& graph);

/// What Solve does, by Gauss-Newton on the banded normal equations (`Linearize`), damped as by
/// Levenberg and Marquardt where a step does not lower the cost: time and memory linear in the
/// number of states. Ends when the next step is known to move nothing by more than 1e-7 of its
/// standard deviation, or the cost by less than the tolerance says.
BandedSolution SolveBanded(const SolveOptions& options, Graph* graph);

}  // namespace tagtwist
