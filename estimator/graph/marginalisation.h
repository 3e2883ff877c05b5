#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/linear_system.h"
#include "frontend/base/quadratic_form.h"

namespace tagtwist::internal {

/// Marginalises the graph's first state: the factors that touch it, directly or through a tracked
/// point seen from it, become one Gaussian prior on the states that they leave (Schur complement,
/// linearised at the graph's values). Returned with its blocks numbered for the graph without that
/// state; nullopt when those factors say nothing about the rest.
/// The prior holds all that the removed factors knew: they must be dropped, see
/// UsedByMarginalisation.
std::optional<Factor> MarginalizeFirstState(const Graph& graph);

/// What normal equations whose band reaches over all states say of the others once the first is
/// eliminated (M8), in the error states of GraphState; the cost is left out.
QuadraticForm<Eigen::Dynamic> EliminateFirst(const LinearSystem& system);

/// A Gaussian prior on a graph's first states with that Hessian and gradient at those: what
/// MarginalizeFirstState makes of all that is known of them.
Factor GaussianPrior(const std::vector<GraphState>& states, const Eigen::MatrixXd& hessian,
                     const Eigen::VectorXd& gradient);

/// Which factors MarginalizeFirstState consumes: one flag a factor.
std::vector<bool> UsedByMarginalisation(const Graph& graph);

}  // namespace tagtwist::internal
