#pragma once
#include <Eigen/Core>

#include "estimator/graph/graph_state.h"
#include "estimator/linear/block.h"

namespace tagtwist::internal {

/// In which tangent what is known of states that have left is a quadratic form. A world that is
/// turned as a whole, states and all, moves every state along the same direction of W's tangent,
/// wherever the states are; along another one of the states' own for each place. A few small tags
/// hardly show such a turn. With forms in the states' own tangents, made at one place and used at
/// another, it comes to be known by itself: sigmas are too small by then (Huang, Mourikis and
/// Roumeliotis 2010; with errors in W Barrau and Bonnabel 2017).
enum class PriorTangent {
  kOwn,    // GraphState's error state
  kWorld,  // DifferenceInWorld
};

/// From a reference to a state, 18 entries: [turn in W; what of position and velocity in W is left
/// when the reference is turned so about W's origin; of the rest, an IMU's biases in place of
/// accelerations, the difference], in the order of GraphState's error state. Difference of kOwn.
GraphStep DifferenceInWorld(const GraphState& state, const GraphState& reference,
                            PriorTangent tangent);

/// Its derivative by a step of the state.
Block DifferenceInWorldByStep(const GraphState& state, const GraphState& reference,
                              PriorTangent tangent);

}  // namespace tagtwist::internal
