#pragma once
#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "estimator/graph/graph_state.h"

namespace tagtwist {

/// Which variable a factor touches: the pose or the rates of a state, or a tracked point.
struct BlockRef {
  enum class Kind { kPose, kRates, kPoint };
  Kind kind = Kind::kPose;
  int index = 0;  // into Graph::states, or Graph::points
};

enum class FactorKind { kTag, kTrack, kMotion, kPrior };

/// A cost and the variables it touches, in the order of its blocks.
struct Factor {
  FactorKind kind = FactorKind::kTag;
  std::shared_ptr<ceres::CostFunction> cost;  // immutable, shared by copies of the graph
  std::vector<BlockRef> blocks;
  double huber_delta = 0;  // threshold on the norm of the whitened residual; 0: no robust loss
  int source = -1;         // kTag: which tag of its frame; kTrack: which segment; else -1
};

/// A factor graph over consecutive states: plain values, no solver state inside.
struct Graph {
  std::vector<GraphState> states;
  std::vector<Eigen::Vector2d> points;  // x, y on a plane of the map [m]
  std::vector<Factor> factors;

  /// First parameter of a block.
  double* Parameters(const BlockRef& block);
  const double* Parameters(const BlockRef& block) const;
};

}  // namespace tagtwist
