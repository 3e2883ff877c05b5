#pragma once
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/linear_system.h"
#include "frontend/base/quadratic_form.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// All factors of a graph that touch the pose of one state and nothing else, the tags that it sees
/// as a rule, as one quadratic form in that pose.
struct PoseForm {
  std::vector<size_t> factors;  // indices in the graph
  bool is_stale = true;         // the rest is not of these factors: to be linearised
  QuadraticForm<6, Pose> form;
  std::vector<double> squared_norms;  // of their whitened residuals, without a robust weight
  bool is_robust = false;             // a factor has a weight below 1
  bool is_partial = false;            // a factor could not be evaluated there
  double information = 0;             // that all factors had, see Factor; 0 where they differed

  /// About the state's pose in the graph. False where a factor cannot be evaluated there; it is
  /// left out, its norm 0. `scratch`: memory that is reused.
  bool Linearize(const Graph& graph, LinearFactor* scratch);

  /// What the form is to be multiplied by: the factors' information now over that when they were
  /// linearised.
  double Scale(const Graph& graph) const;

  /// Whether it is the factors' form in the tangent at that pose still. A move d, in rad and m,
  /// changes the Jacobians by about its size, and so the whitened residuals by that times what d
  /// itself changes them by: so much may be `neglected`. Attitude and position trade against one
  /// another, so that far less than that shows.
  bool Holds(const Graph& graph, const Pose& pose, double neglected) const;

  /// Huber's weight of its i-th factor when last linearised.
  double Weight(const Graph& graph, size_t i) const;
};

}  // namespace tagtwist::internal
