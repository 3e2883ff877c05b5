#include "estimator/evaluation/alignment.h"

#include <gtest/gtest.h>

#include <cmath>

#include "estimator/evaluation/evaluation.h"
#include "tests/support/evaluation_data.h"

namespace tagtwist::internal::alignment_test {
namespace {

const Pose kTruthFromWorld = MakePose(ExpSo3({0.3, -0.2, 2.0}), {4, -1, 0.5});
const Pose kBodyFromMarker = MakePose(ExpSo3({0.02, 1.2, -0.4}), {0.03, -0.05, 0.08});

// Truth as a marker system would give it: another world, another frame on the body.
std::vector<TruthSample> MarkerTruth(double duration_s, double rate_hz, double late_s,
                                     const Pose& body_from_marker) {
  std::vector<TruthSample> out;
  for (const TruthSample& s : SmoothTruth(duration_s, rate_hz)) {
    const PoseSample moved = Transform({s.t_ns, s.world_from_body, s.twist, std::nullopt},
                                       kTruthFromWorld, body_from_marker);
    out.push_back({s.t_ns + std::llround(1e9 * late_s), moved.world_from_body, moved.twist});
  }
  return out;
}

void ExpectPoseNear(const Pose& a, const Pose& b, double tolerance) {
  EXPECT_LT(LogSo3(a.rotation().conjugate() * b.rotation()).norm(), tolerance);
  EXPECT_LT((a.translation() - b.translation()).norm(), tolerance);
}

AlignmentOptions Options(AlignmentKind kind, bool offset = false) {
  AlignmentOptions o;
  o.kind = kind;
  o.estimate_time_offset = offset;
  return o;
}

TEST(Alignment, Se3RecoversAKnownTransform) {
  const auto truth = MarkerTruth(10, 100, 0, Pose());
  const auto a = EstimateAlignment(SmoothSeries(0, 500, 50), truth, Options(AlignmentKind::kSe3));
  ASSERT_TRUE(a);
  ExpectPoseNear(a->truth_from_world, kTruthFromWorld, 1e-9);
  ExpectPoseNear(a->body_from_marker, Pose(), 1e-15);
}

TEST(Alignment, NoneLeavesEverythingAsItIs) {
  const auto a = EstimateAlignment({}, {}, Options(AlignmentKind::kNone));
  ASSERT_TRUE(a);
  ExpectPoseNear(a->truth_from_world, Pose(), 1e-15);
}

TEST(Alignment, HandEyeRecoversBothTransforms) {
  const auto truth = MarkerTruth(20, 100, 0, kBodyFromMarker);
  const auto a =
      EstimateAlignment(SmoothSeries(0, 1000, 50), truth, Options(AlignmentKind::kHandEye));
  ASSERT_TRUE(a);
  ExpectPoseNear(a->truth_from_world, kTruthFromWorld, 1e-6);
  ExpectPoseNear(a->body_from_marker, kBodyFromMarker, 1e-6);
}

// Truth at 2 kHz, so that interpolating it costs less than the tolerance.
TEST(Alignment, HandEyeRecoversATimeOffsetToo) {
  const auto truth = MarkerTruth(20, 2000, 0.1234, kBodyFromMarker);
  const auto a =
      EstimateAlignment(SmoothSeries(0.5, 900, 50), truth, Options(AlignmentKind::kHandEye, true));
  ASSERT_TRUE(a);
  EXPECT_NEAR(a->time_offset_s, 0.1234, 1e-6);
  ExpectPoseNear(a->truth_from_world, kTruthFromWorld, 1e-6);
  ExpectPoseNear(a->body_from_marker, kBodyFromMarker, 1e-6);
}

// Noise on the ground truth; 13 parameters of 20 flights.
TEST(Alignment, HandEyeErrorsOverTheirSigmasAreChiSquare) {
  constexpr int kFlights = 20;
  std::mt19937_64 rng(11);
  double nees = 0;
  for (int flight = 0; flight < kFlights; ++flight) {
    auto truth = MarkerTruth(12, 100, 0.02, kBodyFromMarker);
    for (TruthSample& s : truth) {
      const StateVector n = NormalVector(rng);
      s.world_from_body = MakePose(s.world_from_body.rotation() * ExpSo3(0.002 * n.head<3>()),
                                   s.world_from_body.translation() + 0.001 * n.segment<3>(3));
    }
    const auto a = EstimateAlignment(SmoothSeries(0.5, 210, 20), truth,
                                     Options(AlignmentKind::kHandEye, true));
    ASSERT_TRUE(a && a->sigmas.Any());
    const auto sum = [](const Pose& is, const Pose& truly,
                        const Eigen::Matrix<double, 6, 1>& sigmas) {
      Eigen::Matrix<double, 6, 1> error;
      error << LogSo3(truly.rotation().conjugate() * is.rotation()),
          is.translation() - truly.translation();
      return error.cwiseQuotient(sigmas).squaredNorm();
    };
    const double clock = (a->time_offset_s - 0.02) / a->sigmas.time_offset_s;
    nees += sum(a->truth_from_world, kTruthFromWorld, a->sigmas.truth_from_world) +
            sum(a->body_from_marker, kBodyFromMarker, a->sigmas.body_from_marker) + clock * clock;
    EXPECT_LT(a->sigmas.body_from_marker.tail<3>().maxCoeff(), 0.001);
    EXPECT_LT(a->sigmas.time_offset_s, 0.0005);
  }
  EXPECT_GT(nees / (13 * kFlights),
            0.7);  // entries are correlated: wider than for as many free ones
  EXPECT_LT(nees / (13 * kFlights), 1.3);
}

TEST(Alignment, HandEyeSaysWhatAFlightWithoutTurnsDoesNotShow) {
  PoseSeries upright = SmoothSeries(0, 200, 50);
  std::vector<TruthSample> truth;
  for (PoseSample& s : upright) {
    s.world_from_body = MakePose(Eigen::Quaterniond::Identity(), s.world_from_body.translation());
    truth.push_back({s.t_ns, s.world_from_body, std::nullopt});
  }
  const auto a = EstimateAlignment(upright, truth, Options(AlignmentKind::kHandEye));
  ASSERT_TRUE(a && a->sigmas.Any());
  EXPECT_GT(a->sigmas.body_from_marker.tail<3>().minCoeff(), 1);  // metres, of a prior of 10
  EXPECT_LT(a->body_from_marker.translation().norm(), 0.1);
}

TEST(Alignment, HandEyeOfAStraightFlightStillFitsTheRotations) {
  PoseSeries line = SmoothSeries(0, 200, 50);
  std::vector<TruthSample> truth;
  for (size_t i = 0; i < line.size(); ++i) {
    line[i].world_from_body =
        MakePose(line[i].world_from_body.rotation(), {0.01 * static_cast<double>(i), 0, 1});
    const auto moved = Transform(line[i], kTruthFromWorld, Pose());
    truth.push_back({line[i].t_ns, moved.world_from_body, std::nullopt});
  }
  const auto accuracy = Evaluate(line, truth, {Options(AlignmentKind::kHandEye)});
  ASSERT_TRUE(accuracy);
  EXPECT_LT(accuracy->position_m.rmse, 1e-6);
  EXPECT_LT(accuracy->rotation_rad.rmse, 1e-6);
}

TEST(Alignment, TimeOffsetIsFoundWithoutAndWithAWorldToAlign) {
  const PoseSeries estimate = SmoothSeries(0.5, 900, 50);
  std::vector<TruthSample> truth = SmoothTruth(20, 2000);
  for (TruthSample& s : truth) s.t_ns -= 87'650'000;
  const auto a = EstimateAlignment(estimate, truth, Options(AlignmentKind::kNone, true));
  ASSERT_TRUE(a);
  EXPECT_NEAR(a->time_offset_s, -0.08765, 1e-5);
  const auto b = EstimateAlignment(estimate, MarkerTruth(20, 2000, 0.05, Pose()),
                                   Options(AlignmentKind::kSe3, true));
  ASSERT_TRUE(b);
  EXPECT_NEAR(b->time_offset_s, 0.05, 1e-5);
}

TEST(Alignment, TooFewMatchesAreAnError) {
  const auto a =
      EstimateAlignment(SmoothSeries(0, 2, 50), SmoothTruth(1, 100), Options(AlignmentKind::kSe3));
  ASSERT_FALSE(a);
  EXPECT_EQ(a.error().message, "alignment needs at least 3 poses with ground truth, got 2");
}

// Twists measured at the marker agree with a numeric derivative of the marker's pose.
TEST(Transform, TwistIsTheDerivativeOfTheTransformedPose) {
  const double t = 3.2, h = 1e-6;
  const auto at = [](double time) {
    const BodyState s = SmoothState(time);
    return Transform({0, s.world_from_body, s.twist, std::nullopt}, kTruthFromWorld,
                     kBodyFromMarker);
  };
  const Pose before = at(t - h).world_from_body, after = at(t + h).world_from_body;
  const Twist twist = *at(t).twist;
  EXPECT_LT((twist.v_world - (after.translation() - before.translation()) / (2 * h)).norm(), 1e-8);
  EXPECT_LT((twist.omega_body - LogSo3(before.rotation().conjugate() * after.rotation()) / (2 * h))
                .norm(),
            1e-8);
}

// The covariance goes through the Jacobian of the transform, checked column by column.
TEST(Transform, CovarianceFollowsTheNumericJacobian) {
  const BodyState s = SmoothState(3.2);
  const auto moved = [&](const StateVector& d) {
    const BodyState p = Retract(s, d);
    const auto m =
        Transform({0, p.world_from_body, p.twist, std::nullopt}, kTruthFromWorld, kBodyFromMarker);
    return BodyState{m.world_from_body, *m.twist};
  };
  StateCovariance jacobian;
  for (int i = 0; i < 12; ++i) {
    const StateVector h = 1e-6 * StateVector::Unit(i);
    jacobian.col(i) = Difference(moved(h), moved(-h)) / 2e-6;
  }
  std::mt19937_64 rng(7);
  const StateCovariance p = RealisticCovariance(rng);
  const auto out = Transform({0, s.world_from_body, s.twist, p}, kTruthFromWorld, kBodyFromMarker);
  const StateCovariance expected = jacobian * p * jacobian.transpose();
  EXPECT_LT((*out.covariance - expected).norm(), 1e-8 * expected.norm());
  EXPECT_GT((expected - p).norm(), 0.1 * p.norm());
}

TEST(Transform, NeesDoesNotDependOnTheFramesItIsTakenIn) {
  std::mt19937_64 rng(8);
  PoseSeries estimate = SmoothSeries(0, 100, 50);
  for (PoseSample& s : estimate) s.covariance = RealisticCovariance(rng);
  auto truth = SmoothTruth(5, 50);
  for (TruthSample& s : truth) s.world_from_body.params(4) += 0.004;
  const auto plain = Evaluate(estimate, truth, {});
  std::vector<TruthSample> seen_elsewhere;
  PoseSeries moved;
  for (const TruthSample& s : truth) {
    const auto m = Transform({s.t_ns, s.world_from_body, s.twist, std::nullopt}, kTruthFromWorld,
                             kBodyFromMarker);
    seen_elsewhere.push_back({s.t_ns, m.world_from_body, m.twist});
  }
  for (const auto& s : estimate) moved.push_back(Transform(s, kTruthFromWorld, kBodyFromMarker));
  const auto elsewhere = Evaluate(moved, seen_elsewhere, {});
  ASSERT_TRUE(plain && elsewhere && plain->nees && elsewhere->nees);
  EXPECT_NEAR(plain->nees->mean, elsewhere->nees->mean, 1e-6 * plain->nees->mean);
}

TEST(Roughness, OfWhiteNoiseIsItsStandardDeviation) {
  std::mt19937_64 rng(9);
  PoseSeries noisy = SmoothSeries(0, 3000, 50);
  for (PoseSample& s : noisy) {
    const StateVector n = NormalVector(rng);
    s.twist->v_world += 0.1 * n.head<3>() / std::sqrt(3.0);
    s.twist->omega_body += 0.5 * n.tail<3>() / std::sqrt(3.0);
  }
  const auto roughness = ComputeRoughness(noisy);
  ASSERT_TRUE(roughness);
  EXPECT_NEAR(roughness->velocity_mps, 0.1, 0.005);
  EXPECT_NEAR(roughness->rate_radps, 0.5, 0.025);
  EXPECT_FALSE(ComputeRoughness({}));
}

}  // namespace
}  // namespace tagtwist::internal::alignment_test
