#pragma once
#include <optional>

#include "estimator/graph/graph.h"

namespace tagtwist {

/// Marginalises the graph's first state: the factors that touch it, directly or through a tracked
/// point seen from it, become one Gaussian prior on the states that they leave (Schur complement,
/// linearised at the graph's values). Returned with its blocks numbered for the graph without that
/// state; nullopt when those factors say nothing about the rest.
/// The prior holds all that the removed factors knew: they must be dropped, see
/// UsedByMarginalisation.
std::optional<Factor> MarginalizeFirstState(const Graph& graph);

/// A Gaussian prior on a graph's first state with that Hessian and gradient at `state`: what
/// MarginalizeFirstState makes of all that is known of one state.
Factor GaussianPrior(const GraphState& state, const Eigen::MatrixXd& hessian,
                     const Eigen::VectorXd& gradient);

/// Which factors MarginalizeFirstState consumes: one flag a factor.
std::vector<bool> UsedByMarginalisation(const Graph& graph);

}  // namespace tagtwist
