#pragma once
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// Between two states dt_s apart, at a share of that time: cubic in position and in the turn since
/// the first, with the twists as slopes. Turns are so small that a body rate is their slope.
inline BodyState CubicBetween(const BodyState& first, const BodyState& second, double dt_s,
                              double share) {
  const PoseStep step = Difference(second.world_from_body, first.world_from_body);
  PoseStep slope_first, slope_second;
  slope_first << first.twist.omega_body, first.twist.v_world;
  slope_second << second.twist.omega_body, second.twist.v_world;
  const double w = share;
  const PoseStep way =
      w * w * (3 - 2 * w) * step + dt_s * w * (1 - w) * ((1 - w) * slope_first - w * slope_second);
  const PoseStep slope = 6 * w * (1 - w) / dt_s * step + (1 - w) * (1 - 3 * w) * slope_first +
                         w * (3 * w - 2) * slope_second;
  BodyState out;
  out.world_from_body = Retract(first.world_from_body, way);
  out.twist.omega_body = slope.head<3>();
  out.twist.v_world = slope.tail<3>();
  return out;
}

}  // namespace tagtwist::internal
