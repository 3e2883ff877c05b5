#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/linear/block_banded.h"
#include "estimator/solve/ceres_solver.h"

namespace tagtwist::internal {

/// What SolveBanded found.
struct BandedSolution {
  SolveSummary summary;
  std::optional<BlockBandedCholesky> normal_equations;  // at the solution; where usable
};

/// Says of a factorisation that failed which state it failed at.
std::string NotPositiveDefinite(const BlockBandedCholesky& cholesky,
                                const std::vector<GraphState>& states);

/// Whether SolveBanded can do it: no tracked point in the graph.
bool IsBanded(const Graph& graph);

/// What Solve does, by SolveLeastSquares on the banded normal equations (`Linearize`): time and
/// memory linear in the number of states. Ends where the next step is no step (kNoDecrease), as
/// the last two foretell, or lowers the cost by less than the tolerance says.
BandedSolution SolveBanded(const SolveOptions& options, Graph* graph);

}  // namespace tagtwist::internal
