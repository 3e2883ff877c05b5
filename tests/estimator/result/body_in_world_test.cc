#include "estimator/result/body_in_world.h"

#include <gtest/gtest.h>

#include "frontend/types/so3.h"

namespace tagtwist::internal::body_in_world_test {
namespace {

FrameEstimate AsFrame(const BodyState& state) {
  FrameEstimate out;
  out.status = FrameStatus::kOk;
  out.state = state;
  return out;
}

const BodyState kCarrier{MakePose(ExpSo3({0.3, -1.1, 0.4}), {1.2, -0.4, 2.1}),
                         {{0.5, -0.3, 0.8}, {1.1, 0.4, -0.7}}};
const BodyState kRelative{MakePose(ExpSo3({-0.9, 0.2, 1.3}), {0.2, 0.9, -1.6}),
                          {{-1.2, 0.4, 0.3}, {-0.6, 1.9, 0.5}}};

Pose After(const BodyState& state, double s) {
  return MakePose(state.world_from_body.rotation() * ExpSo3(s * state.twist.omega_body),
                  state.world_from_body.translation() + s * state.twist.v_world);
}

TEST(BodyInWorld, HasThePoseAndTheTwistOfABodyThatMoves) {
  const BodyState body{MakePose(ExpSo3({0.7, 0.5, -0.2}), {-0.3, 0.6, 0.2}),
                       {{0.4, 0.9, -0.5}, {3.0, -2.0, 5.0}}};
  constexpr double kStepS = 1e-5;
  const auto relative_at = [&](double s) { return Inverse(After(body, s)) * After(kCarrier, s); };
  const BodyState relative{relative_at(0),
                           TwistBetween(relative_at(-kStepS), relative_at(kStepS), 2 * kStepS)};
  const FrameEstimate found = BodyInWorld(AsFrame(kCarrier), AsFrame(relative));
  EXPECT_LT(Difference(found.state, body).norm(), 1e-7);
}

TEST(BodyInWorld, CarriesTheErrorsOfBothOn) {
  constexpr double kStep = 1e-6;
  const BodyState base = BodyInWorld(AsFrame(kCarrier), AsFrame(kRelative)).state;
  for (int k = 0; k < 12; ++k) {
    for (const bool of_carrier : {true, false}) {
      const StateVector step = kStep * StateVector::Unit(k);
      FrameEstimate carrier = AsFrame(kCarrier), relative = AsFrame(kRelative);
      (of_carrier ? carrier : relative).covariance = step * step.transpose();
      const StateCovariance told = BodyInWorld(carrier, relative).covariance;
      FrameEstimate& moved = of_carrier ? carrier : relative;
      moved.state = Retract(moved.state, step);
      const StateVector error = Difference(BodyInWorld(carrier, relative).state, base);
      EXPECT_LT((told - error * error.transpose()).norm(), 1e-4 * told.norm())
          << k << (of_carrier ? " of the carrier" : " of the body");
    }
  }
}

TEST(BodyInWorld, IsKnownNoBetterThanEither) {
  FrameEstimate carrier = AsFrame(kCarrier), relative = AsFrame(kRelative);
  carrier.status = FrameStatus::kPredicted;
  EXPECT_EQ(BodyInWorld(carrier, relative).status, FrameStatus::kPredicted);
  relative.status = FrameStatus::kNoFix;
  EXPECT_EQ(BodyInWorld(carrier, relative).status, FrameStatus::kNoFix);
}

}  // namespace
}  // namespace tagtwist::internal::body_in_world_test
