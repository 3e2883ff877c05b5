#include "estimator/result/body_in_world.h"

#include <algorithm>
#include <string>

#include "frontend/base/check.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Effect = Eigen::Matrix<double, 12, 12>;  // of one error state on another

// The body's state, and what steps of the two do to it.
struct Composed {
  BodyState state;
  Effect by_carrier, by_relative;
};

Composed Compose(const BodyState& carrier, const BodyState& relative) {
  const Matrix3d r1 = carrier.world_from_body.rotation().toRotationMatrix();
  const Matrix3d r2 = relative.world_from_body.rotation().toRotationMatrix();
  const Matrix3d rotation = r1 * r2.transpose();
  const Vector3d place = relative.world_from_body.translation();
  const Vector3d turns = carrier.twist.omega_body - relative.twist.omega_body;  // in C
  const Vector3d omega = r2 * turns;                                            // in O
  const Vector3d moves = omega.cross(place) + relative.twist.v_world;
  Composed out;
  out.state.world_from_body = carrier.world_from_body * Inverse(relative.world_from_body);
  out.state.twist = {carrier.twist.v_world - rotation * moves, omega};

  // theta = R2 (theta1 - theta2), then p, omega, v, each by theirs and those before.
  out.by_carrier.setZero();
  out.by_relative.setZero();
  for (const bool is_carrier : {true, false}) {
    Effect& by = is_carrier ? out.by_carrier : out.by_relative;
    const double sign = is_carrier ? 1 : -1;
    by.block<3, 3>(0, 0) = sign * r2;
    by.block<3, 3>(9, 9) = sign * r2;
    if (!is_carrier) by.block<3, 3>(9, 0) = -r2 * Hat(turns);
    by.middleRows<3>(3) = rotation * Hat(place) * by.middleRows<3>(0);
    by.middleRows<3>(6) =
        rotation * Hat(moves) * by.middleRows<3>(0) + rotation * Hat(place) * by.middleRows<3>(9);
  }
  out.by_carrier.block<3, 3>(3, 3) += Matrix3d::Identity();
  out.by_carrier.block<3, 3>(6, 6) += Matrix3d::Identity();
  out.by_relative.block<3, 3>(3, 3) -= rotation;
  out.by_relative.block<3, 3>(6, 3) -= rotation * Hat(omega);
  out.by_relative.block<3, 3>(6, 6) -= rotation;
  return out;
}

std::optional<Twist> TwistOf(const ClosedForm& carrier, const std::optional<Twist>& of_carrier,
                             const ClosedForm& relative, const std::optional<Twist>& of_relative) {
  if (!of_carrier || !of_relative) return std::nullopt;
  return Compose({*carrier.world_from_body, *of_carrier}, {*relative.world_from_body, *of_relative})
      .state.twist;
}

ClosedForm Compose(const ClosedForm& carrier, const ClosedForm& relative) {
  ClosedForm out;
  if (!carrier.world_from_body || !relative.world_from_body) return out;
  out.world_from_body = *carrier.world_from_body * Inverse(*relative.world_from_body);
  out.twist_plain = TwistOf(carrier, carrier.twist_plain, relative, relative.twist_plain);
  out.twist_ransac = TwistOf(carrier, carrier.twist_ransac, relative, relative.twist_ransac);
  out.twist_low_pass = TwistOf(carrier, carrier.twist_low_pass, relative, relative.twist_low_pass);
  return out;
}

FrameStatus WorseOf(FrameStatus a, FrameStatus b) { return std::max(a, b); }

void PutInWorld(const std::vector<FrameEstimate>& carriers, std::vector<FrameEstimate>* frames) {
  if (frames->empty()) return;  // it has no estimate
  TAGTWIST_CHECK(frames->size() == carriers.size(),
                 "a body is estimated at the frames of its carrier, but it has " +
                     std::to_string(frames->size()) + " of " + std::to_string(carriers.size()));
  for (size_t i = 0; i < carriers.size(); ++i) {
    TAGTWIST_CHECK(frames->at(i).t_ns == carriers[i].t_ns,
                   "a body's frames are its carrier's, one by one");
    (*frames)[i] = BodyInWorld(carriers[i], (*frames)[i]);
  }
}

}  // namespace

FrameEstimate BodyInWorld(const FrameEstimate& carrier_in_world,
                          const FrameEstimate& carrier_about_body) {
  FrameEstimate out = carrier_about_body;
  out.status = WorseOf(carrier_in_world.status, carrier_about_body.status);
  out.pose_bound.reset();
  out.closed_form = Compose(carrier_in_world.closed_form, carrier_about_body.closed_form);
  if (out.status == FrameStatus::kNoFix) return out;
  const Composed composed = Compose(carrier_in_world.state, carrier_about_body.state);
  out.state = composed.state;
  out.covariance =
      composed.by_carrier * carrier_in_world.covariance * composed.by_carrier.transpose() +
      composed.by_relative * carrier_about_body.covariance * composed.by_relative.transpose();
  return out;
}

void PutInWorld(const Estimate& carrier_in_world, Estimate* about_body) {
  PutInWorld(carrier_in_world.frames, &about_body->frames);
  PutInWorld(carrier_in_world.lagged, &about_body->lagged);
}

}  // namespace tagtwist::internal
