#include "frontend/types/body_state.h"

#include "frontend/types/so3.h"

namespace tagtwist {

StateVector Difference(const BodyState& state, const BodyState& reference) {
  StateVector d;
  d << LogSo3(reference.world_from_body.rotation().conjugate() * state.world_from_body.rotation()),
      state.world_from_body.translation() - reference.world_from_body.translation(),
      state.twist.v_world - reference.twist.v_world,
      state.twist.omega_body - reference.twist.omega_body;
  return d;
}

BodyState Perturb(const BodyState& reference, const StateVector& difference) {
  BodyState out;
  out.world_from_body =
      MakePose(reference.world_from_body.rotation() * ExpSo3(difference.head<3>()),
               reference.world_from_body.translation() + difference.segment<3>(3));
  out.twist.v_world = reference.twist.v_world + difference.segment<3>(6);
  out.twist.omega_body = reference.twist.omega_body + difference.tail<3>();
  return out;
}

}  // namespace tagtwist
