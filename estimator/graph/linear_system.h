#pragma once
#include <Eigen/Core>
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/linear/block_banded.h"

namespace tagtwist::internal {

/// A factor linearised at the graph's values: whitened residual and Jacobian in the tangents of its
/// blocks side by side (pose 6, rates 12, point 2), both scaled by the square root of the robust
/// weight.
struct LinearFactor {
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  double weight = 1;  // of the Huber loss, in (0, 1]
};

/// Returns false when the factor cannot be evaluated here (a point behind the camera).
bool LinearizeFactor(const Graph& graph, const Factor& factor, LinearFactor* out);

/// Half the sum of squares of a linearised factor, under its Huber loss.
double RobustCost(const Factor& factor, const LinearFactor& linear);

/// Columns of a block in its factor's Jacobian.
int TangentSize(BlockRef::Kind kind);

/// Normal equations H d = -gradient over the error states of
/// all states (see GraphState), the points eliminated by their Schur complement.
struct LinearSystem {
  BlockBandedMatrix hessian;
  Eigen::VectorXd gradient;
  double cost = 0;       // half the sum of squares, robust
  bool is_whole = true;  // no factor had to be left out because it cannot be evaluated here
};

/// Most states apart that two blocks of a factor, or two views of a point, lie; at least 1. Of
/// those factors whose entry in `use` is true (all when empty).
int Bandwidth(const Graph& graph, const std::vector<bool>& use = {});

/// One of so many states, nothing known of them yet. `memory`, a matrix that is no longer needed,
/// becomes its Hessian: the matrix is large.
LinearSystem ZeroSystem(int size, int bandwidth, BlockBandedMatrix memory = {});

/// Adds a linearised factor, but for its cost: by the blocks of states that it touches, which must
/// lie within the band. `first_state`: the graph's that is the system's first.
void AddFactor(const Factor& factor, const LinearFactor& linear, LinearSystem* system,
               int first_state = 0);

/// Normal equations of those factors whose entry in `use` is true (all when empty).
LinearSystem Linearize(const Graph& graph, const std::vector<bool>& use = {},
                       BlockBandedMatrix memory = {});

}  // namespace tagtwist::internal
