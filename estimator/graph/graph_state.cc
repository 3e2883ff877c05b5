#include "estimator/graph/graph_state.h"

namespace tagtwist {

GraphState ToGraphState(int64_t t_ns, const BodyState& state, const Acceleration& acceleration,
                        const MotionScale& motion) {
  GraphState out;
  out.motion = motion;
  out.t_ns = t_ns;
  out.pose = state.world_from_body;
  out.rates << state.twist.v_world, state.twist.omega_body, acceleration.a_world,
      acceleration.alpha_body;
  return out;
}

BodyState ToBodyState(const GraphState& state) {
  BodyState out;
  out.world_from_body = state.pose;
  out.twist.v_world = state.rates.segment<3>(0);
  out.twist.omega_body = state.rates.segment<3>(3);
  return out;
}

Acceleration ToAcceleration(const GraphState& state) {
  return {state.rates.segment<3>(6), state.rates.segment<3>(9)};
}

GraphState Retract(const GraphState& state, const GraphStep& step) {
  GraphState out = state;
  out.pose = Retract(state.pose, step.head<6>());
  out.rates += step.tail<12>();
  return out;
}

GraphStep Difference(const GraphState& state, const GraphState& reference) {
  GraphStep out;
  out << Difference(state.pose, reference.pose), state.rates - reference.rates;
  return out;
}

}  // namespace tagtwist
