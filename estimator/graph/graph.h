#pragma once
#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "estimator/graph/graph_state.h"

namespace tagtwist::internal {

/// Which variable a factor touches: the pose or the rates of a state, or a tracked point.
struct BlockRef {
  enum class Kind { kPose, kRates, kPoint };
  Kind kind = Kind::kPose;
  int index = 0;  // into Graph::states, or Graph::points
};

/// Of states one after the other: each [+] its part of the step; and the steps that lead from the
/// references, as many as there are.
std::vector<GraphState> Retract(const std::vector<GraphState>& states, const Eigen::VectorXd& step);
Eigen::VectorXd Difference(const std::vector<GraphState>& states,
                           const std::vector<GraphState>& references);

/// What a factor is, for those who ask: noise learning, contradictions. Solving, marginalising and
/// inverting go by the blocks that it touches.
enum class FactorKind { kTag, kTrack, kMotion, kPrior, kOther };

/// A cost and the variables it touches, in the order of its blocks.
struct Factor {
  FactorKind kind = FactorKind::kTag;
  std::shared_ptr<ceres::CostFunction> cost;  // immutable, shared by copies of the graph
  std::vector<BlockRef> blocks;
  double huber_delta = 0;  // threshold on the norm of the whitened residual; 0: no robust loss
  int source = -1;         // kTag: which tag of its frame; kTrack: which segment; else -1
  /// What multiplies the squares of the cost's residual: one over the variance, where the cost is
  /// in the unit of what was measured.
  double information = 1;
  double own_log_det = 0;  // log det of the inverse noise covariance that the cost whitens by

  bool IsOnOnePose() const {
    return blocks.size() == 1 && blocks.front().kind == BlockRef::Kind::kPose;
  }
  /// log det of the inverse noise covariance that the factor is whitened by.
  double LogDetInformation() const;
};

/// A factor graph over consecutive states: plain values, no solver state inside.
struct Graph {
  std::vector<GraphState> states;
  std::vector<Eigen::Vector2d> points;  // x, y on a plane of the map [m]
  std::vector<Factor> factors;
  int n_left_out = 0;  // factors that could not be evaluated where the graph was built

  /// First parameter of a block.
  double* Parameters(const BlockRef& block);
  const double* Parameters(const BlockRef& block) const;
};

}  // namespace tagtwist::internal
