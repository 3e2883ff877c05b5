#pragma once
#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <vector>

#include "frontend/types/body_state.h"

namespace tagtwist {

/// Which variable a factor touches: the pose or the rates of a state, or a tracked point.
struct BlockRef {
  enum class Kind { kPose, kRates, kPoint };
  Kind kind = Kind::kPose;
  int index = 0;  // into Graph::states, or Graph::points
};

/// Accelerations of a body, which the motion prior needs as states of their own: of its origin in
/// W [m/s^2] and of its rate in B [rad/s^2].
struct Acceleration {
  Eigen::Vector3d a_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha_body = Eigen::Vector3d::Zero();
};

/// A state as the solver holds it. Its error state, 18 entries: that of BodyState, then
/// [a_world(3); alpha_body(3)].
struct GraphState {
  int64_t t_ns = 0;
  Pose pose;  // world_from_body
  Eigen::Matrix<double, 12, 1> rates =
      Eigen::Matrix<double, 12, 1>::Zero();  // [v_world; omega_body; a_world; alpha_body]
};
GraphState ToGraphState(int64_t t_ns, const BodyState& state, const Acceleration& acceleration);
BodyState ToBodyState(const GraphState& state);
Acceleration ToAcceleration(const GraphState& state);
/// A step in the error state of GraphState.
using GraphStep = Eigen::Matrix<double, 18, 1>;
/// state [+] step.
GraphState Retract(const GraphState& state, const GraphStep& step);
/// The step that leads from the reference to the state: state = reference [+] step.
GraphStep Difference(const GraphState& state, const GraphState& reference);

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
