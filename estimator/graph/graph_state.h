#pragma once
#include <Eigen/Core>
#include <cstdint>

#include "frontend/types/body_state.h"

namespace tagtwist {

/// Accelerations of a body, which the motion prior needs as states of their own: of its origin in
/// W [m/s^2] and of its rate in B [rad/s^2].
struct Acceleration {
  Eigen::Vector3d a_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d alpha_body = Eigen::Vector3d::Zero();
};

/// By what the motion prior's densities are multiplied over an interval: motion is not of one kind
/// throughout (motion_banks.h).
struct MotionScale {
  double linear = 1, angular = 1;
  bool breaks = false;  // the body was carried: nothing of the motion leads over the interval
};

/// A state as the solver holds it. Its error state, 18 entries: that of BodyState, then
/// [a_world(3); alpha_body(3)].
struct GraphState {
  int64_t t_ns = 0;
  Pose pose;  // world_from_body
  Eigen::Matrix<double, 12, 1> rates =
      Eigen::Matrix<double, 12, 1>::Zero();  // [v_world; omega_body; a_world; alpha_body]
  MotionScale motion;                        // from the state before to this one
};
GraphState ToGraphState(int64_t t_ns, const BodyState& state, const Acceleration& acceleration,
                        const MotionScale& motion = {});
BodyState ToBodyState(const GraphState& state);
Acceleration ToAcceleration(const GraphState& state);
/// A step in the error state of GraphState.
using GraphStep = Eigen::Matrix<double, 18, 1>;
/// state [+] step.
GraphState Retract(const GraphState& state, const GraphStep& step);
/// The step that leads from the reference to the state: state = reference [+] step.
GraphStep Difference(const GraphState& state, const GraphState& reference);

}  // namespace tagtwist
