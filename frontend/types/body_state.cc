#include "frontend/types/body_state.h"

namespace tagtwist {

StateVector Difference(const BodyState& state, const BodyState& reference) {
  StateVector d;
  d << Difference(state.world_from_body, reference.world_from_body),
      state.twist.v_world - reference.twist.v_world,
      state.twist.omega_body - reference.twist.omega_body;
  return d;
}

BodyState Retract(const BodyState& state, const StateVector& step) {
  BodyState out;
  out.world_from_body = Retract(state.world_from_body, step.head<6>());
  out.twist.v_world = state.twist.v_world + step.segment<3>(6);
  out.twist.omega_body = state.twist.omega_body + step.tail<3>();
  return out;
}

Twist TwistBetween(const Pose& first, const Pose& second, double dt_s) {
  const PoseStep way = Difference(second, first);
  return {way.tail<3>() / dt_s, way.head<3>() / dt_s};
}

}  // namespace tagtwist
