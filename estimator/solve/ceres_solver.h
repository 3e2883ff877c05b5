#pragma once
#include <string>

#include "estimator/graph/graph.h"
#include "frontend/base/time_up.h"

namespace tagtwist {

struct SolveOptions {
  int max_iterations = 30;
  double function_tolerance = 1e-13;  // relative change of the cost that ends the solve
  TimeUp time_up = {};                // ends it after an iteration
};

/// How a solve ended; the caller must look at `usable`.
struct SolveSummary {
  bool usable = false;
  int iterations = 0;
  double final_cost = 0;  // half the sum of squares, robust
  std::string message;
};

/// Refines all variables of the graph in place by Ceres (Levenberg-Marquardt; points eliminated by
/// the Schur complement). One thread: sums in a fixed order, the same bytes on every run.
SolveSummary Solve(const SolveOptions& options, Graph* graph);

}  // namespace tagtwist
