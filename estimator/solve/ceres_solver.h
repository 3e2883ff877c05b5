#pragma once
#include <string>

#include "estimator/graph/graph.h"
#include "frontend/base/time_up.h"

namespace tagtwist::internal {

struct SolveOptions {
  int max_iterations = 30;
  double function_tolerance = 1e-13;  // relative change of the cost that ends the solve; 0: the
                                      // solve ends where no step is left (kNoDecrease)
  TimeUp time_up = {};                // ends it after an iteration
};

/// The end: no further step moves the states by more than 5e-8 of their standard deviations taken
/// together, half whose square this is.
inline constexpr double kNoDecrease = 1e-15;

/// How a solve ended; the caller must look at `usable`.
struct SolveSummary {
  bool usable = false;
  int iterations = 0;
  double final_cost = 0;  // half the sum of squares, robust
  std::string message;
};

/// Refines all variables of the graph in place by Ceres (Levenberg-Marquardt; points eliminated by
/// the Schur complement). One thread: sums in a fixed order, the same bytes on every run.
/// Ceres goes by the cost, whose rounding hides steps of up to 1e-5 standard deviations. Where
/// there are no points, full steps by its Jacobians, as long as they shrink, then lead to the end.
SolveSummary Solve(const SolveOptions& options, Graph* graph);

}  // namespace tagtwist::internal
