#include "estimator/evaluation/evaluation.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "frontend/types/truth.h"
#include "tests/support/evaluation_data.h"

namespace tagtwist::internal::evaluation_test {
namespace {

TruthSample Sample(int64_t t_ns, double x, double yaw, const std::optional<Twist>& twist = {}) {
  return {t_ns, MakePose(ExpSo3({0, 0, yaw}), {x, 0, 0}), twist};
}

TEST(GroundTruth, ExactStampIsTakenAsItIs) {
  const std::vector<TruthSample> truth = {Sample(0, 0, 0), Sample(500'000'000, 7, 0.3)};
  const auto at = InterpolateTruth(truth, 500'000'000, 0.1);
  ASSERT_TRUE(at);
  EXPECT_EQ(at->world_from_body.params, truth[1].world_from_body.params);
}

TEST(GroundTruth, BetweenSamplesPositionIsLinearAndRotationSlerps) {
  const Twist slow{{1, 0, 0}, {0, 0, 1}}, fast{{3, 0, 0}, {0, 0, 2}};
  const std::vector<TruthSample> truth = {Sample(0, 1, 0.2, slow),
                                          Sample(80'000'000, 3, 0.6, fast)};
  const auto at = InterpolateTruth(truth, 20'000'000, 0.1);
  ASSERT_TRUE(at);
  EXPECT_NEAR(at->world_from_body.translation().x(), 1.5, 1e-12);
  EXPECT_NEAR(LogSo3(at->world_from_body.rotation()).z(), 0.3, 1e-12);
  ASSERT_TRUE(at->twist);
  EXPECT_NEAR(at->twist->v_world.x(), 1.5, 1e-12);
  EXPECT_NEAR(at->twist->omega_body.z(), 1.25, 1e-12);
}

TEST(GroundTruth, NothingIsExtrapolatedAndGapsAreLeftOut) {
  const std::vector<TruthSample> truth = {Sample(0, 0, 0), Sample(100'000'000, 1, 0),
                                          Sample(201'000'000, 2, 0)};
  EXPECT_FALSE(InterpolateTruth(truth, -1, 0.1));
  EXPECT_TRUE(InterpolateTruth(truth, 50'000'000, 0.1));
  EXPECT_FALSE(InterpolateTruth(truth, 150'000'000, 0.1));
  EXPECT_TRUE(InterpolateTruth(truth, 150'000'000, 0.2));
  EXPECT_FALSE(InterpolateTruth(truth, 201'000'001, 0.1));
  EXPECT_FALSE(InterpolateTruth({}, 0, 0.1));
}

TEST(GroundTruth, TwistOfOneNeighbourAloneIsNoTwist) {
  const std::vector<TruthSample> truth = {Sample(0, 0, 0, Twist()), Sample(50'000'000, 1, 0)};
  const auto at = InterpolateTruth(truth, 25'000'000, 0.1);
  ASSERT_TRUE(at);
  EXPECT_FALSE(at->twist);
}

TEST(Statistics, OfAHandMadeList) {
  const ErrorStatistics s = Summarise({4, 0, 3, 1});
  EXPECT_EQ(s.count, 4u);
  EXPECT_DOUBLE_EQ(s.rmse, std::sqrt(26.0 / 4));
  EXPECT_DOUBLE_EQ(s.mean, 2);
  EXPECT_DOUBLE_EQ(s.median, 2);
  EXPECT_DOUBLE_EQ(s.max, 4);
  EXPECT_EQ(Summarise({5, 1, 2}).median, 2);
}

// Constant, known errors give exactly those figures: the norm in 3-D, not per axis.
TEST(Evaluation, KnownErrorsGiveKnownFigures) {
  const auto truth = SmoothTruth(10, 100);
  PoseSeries estimate = SmoothSeries(0.5, 400, 50);
  for (size_t i = 0; i < estimate.size(); ++i) {
    BodyState s{estimate[i].world_from_body, *estimate[i].twist};
    StateVector error = StateVector::Zero();
    error.head<3>() = Eigen::Vector3d(0, 0.03, 0.04) * (i % 2 == 0 ? 1 : -1);
    error.segment<3>(3) = Eigen::Vector3d(0.01, 0.02, 0.02);
    error.segment<3>(6) = Eigen::Vector3d(0.3, 0, 0.4) * (i % 2 == 0 ? 1 : 0);
    error.tail<3>() = Eigen::Vector3d(0, 0, 0.2);
    s = Retract(s, error);
    estimate[i].world_from_body = s.world_from_body;
    estimate[i].twist = s.twist;
  }
  const auto accuracy = Evaluate(estimate, truth, {});
  ASSERT_TRUE(accuracy) << accuracy.error().message;
  EXPECT_EQ(accuracy->frames, 400u);
  EXPECT_EQ(accuracy->matched, 400u);
  EXPECT_NEAR(accuracy->position_m.rmse, 0.03, 1e-9);
  EXPECT_NEAR(accuracy->position_m.median, 0.03, 1e-9);
  EXPECT_NEAR(accuracy->rotation_rad.rmse, 0.05, 1e-9);
  ASSERT_TRUE(accuracy->velocity_mps && accuracy->rate_radps);
  EXPECT_NEAR(accuracy->velocity_mps->rmse, 0.5 / std::sqrt(2.0), 1e-9);
  EXPECT_NEAR(accuracy->velocity_mps->median, 0.25, 1e-9);
  EXPECT_NEAR(accuracy->rate_radps->rmse, 0.2, 1e-7);
  EXPECT_FALSE(accuracy->nees) << "without covariance there is no NEES";
}

// Every other frame's world is off by 1 mm and 2 mrad, and all of them by one large transform: the
// relative error sees the first and not the second.
TEST(Evaluation, RelativeErrorSeesWhatChangesAndNotWhatStays) {
  const auto truth = SmoothTruth(10, 100);
  PoseSeries shifted = SmoothSeries(0, 400, 50), turned = shifted;
  const Pose offset = MakePose(ExpSo3({0.5, -1, 0.2}), {3, 2, 1});
  for (size_t i = 0; i < shifted.size(); ++i) {
    const double odd = i % 2 == 1 ? 1 : 0;
    const Pose shift = MakePose(Eigen::Quaterniond::Identity(), {0, odd * 1e-3, 0});
    const Pose turn = MakePose(ExpSo3({odd * 2e-3, 0, 0}), {0, 0, 0});
    shifted[i].world_from_body = offset * shift * shifted[i].world_from_body;
    turned[i].world_from_body = offset * turn * turned[i].world_from_body;
  }
  const auto a = Evaluate(shifted, truth, {}), b = Evaluate(turned, truth, {});
  ASSERT_TRUE(a && b && a->rpe_frames && a->rpe_time && b->rpe_frames && b->rpe_time);
  EXPECT_EQ(a->rpe_frames->translation_m.count, 399u);
  EXPECT_EQ(a->rpe_time->translation_m.count, 350u);  // 50 frames later
  EXPECT_NEAR(a->rpe_frames->translation_m.rmse, 1e-3, 1e-12);
  EXPECT_NEAR(a->rpe_frames->rotation_rad.rmse, 0, 1e-12);
  EXPECT_NEAR(b->rpe_frames->rotation_rad.rmse, 2e-3, 1e-12);
  EXPECT_NEAR(b->rpe_time->translation_m.rmse, 0, 1e-12);  // an even number of frames
  EXPECT_NEAR(b->rpe_time->rotation_rad.rmse, 0, 1e-12);
  EXPECT_GT(a->position_m.rmse, 1);
}

// Steps of 0.1 m along x, and a stop: the pair's end is where the step is reached first.
TEST(Evaluation, RelativeErrorByDistanceGoesAlongThePath) {
  PoseSeries estimate;
  std::vector<TruthSample> truth;
  const std::vector<double> x_m = {0, 0.1, 0.2, 0.3, 0.3, 0.3, 0.4, 0.5};
  for (size_t i = 0; i < x_m.size(); ++i) {
    const auto t_ns = static_cast<int64_t>(i) * 100'000'000;
    const auto pose = [](double x) {
      return MakePose(Eigen::Quaterniond::Identity(), Eigen::Vector3d(x, 0, 0));
    };
    estimate.push_back({t_ns, pose(x_m[i]), std::nullopt, std::nullopt});
    truth.push_back({t_ns, pose(1.02 * x_m[i] + (i == 4 ? 5 : 0)), std::nullopt});
  }
  EvaluationOptions options;
  options.rpe_metres = 0.3;
  const auto accuracy = Evaluate(estimate, truth, options);
  ASSERT_TRUE(accuracy && accuracy->rpe_distance);
  EXPECT_EQ(accuracy->rpe_distance->translation_m.count, 3u);  // 0-3, 1-6, 2-7; not to 4
  EXPECT_NEAR(accuracy->rpe_distance->translation_m.max, 0.006, 1e-12);
  options.rpe_metres = 0.6;
  EXPECT_FALSE(Evaluate(estimate, truth, options)->rpe_distance);
}

TEST(Evaluation, TruthOfPosesAloneLeavesTwistEntriesOut) {
  auto truth = SmoothTruth(10, 100);
  for (TruthSample& s : truth) s.twist.reset();
  PoseSeries estimate = SmoothSeries(0, 100, 50);
  for (PoseSample& s : estimate) s.covariance = 1e-4 * StateCovariance::Identity();
  const auto accuracy = Evaluate(estimate, truth, {});
  ASSERT_TRUE(accuracy);
  EXPECT_FALSE(accuracy->velocity_mps || accuracy->rate_radps);
  EXPECT_FALSE(accuracy->nees || accuracy->nees_twist);
  EXPECT_TRUE(accuracy->nees_pose);
}

TEST(Evaluation, NoOverlapIsAnErrorThatNamesBothSpans) {
  const auto accuracy = Evaluate(SmoothSeries(20, 10, 50), SmoothTruth(10, 100), {});
  ASSERT_FALSE(accuracy);
  EXPECT_EQ(accuracy.error().message,
            "no pose has ground truth at its time: the trajectory spans 20.000 to 20.180 s, the "
            "ground truth 0.000 to 10.000 s");
  EXPECT_FALSE(Evaluate({}, SmoothTruth(1, 100), {}));
  EXPECT_FALSE(Evaluate(SmoothSeries(0, 10, 50), {}, {}));
}

// Estimates drawn around the truth from a known full covariance, which is then scaled.
Accuracy AccuracyOfDraws(double claimed_scale) {
  std::mt19937_64 rng(5);
  const auto truth = SmoothTruth(20, 50);
  PoseSeries estimate;
  for (const TruthSample& t : truth) {
    const StateCovariance p = RealisticCovariance(rng);
    const StateVector error = p.llt().matrixL() * NormalVector(rng);
    // The truth is a draw around the estimate: Perturb is not symmetric in the second order.
    const BodyState s = Retract(BodyState{t.world_from_body, *t.twist}, -error);
    estimate.push_back({t.t_ns, s.world_from_body, s.twist, claimed_scale * p});
  }
  return *Evaluate(estimate, truth, {});
}

TEST(Nees, OfDrawsFromTheirOwnCovarianceLiesInTheBand) {
  const Accuracy a = AccuracyOfDraws(1.0);
  ASSERT_TRUE(a.nees && a.nees_pose && a.nees_twist);
  EXPECT_EQ(a.nees->count, 1001u);
  for (const auto& [nees, dof] :
       {std::pair(*a.nees, 12), std::pair(*a.nees_pose, 6), std::pair(*a.nees_twist, 6)}) {
    EXPECT_EQ(nees.dof, dof);
    EXPECT_GT(nees.mean, nees.band_low);
    EXPECT_LT(nees.mean, nees.band_high);
    EXPECT_LT(nees.band_high - nees.band_low, 0.1 * dof);
    EXPECT_NEAR(nees.per_dof(), 1, 0.05);
  }
}

TEST(Nees, OfAHalvedCovarianceLiesOutsideTheBand) {
  const Accuracy over = AccuracyOfDraws(0.5), under = AccuracyOfDraws(2.0);
  EXPECT_GT(over.nees->mean, over.nees->band_high);
  EXPECT_GT(over.nees_pose->mean, over.nees_pose->band_high);
  EXPECT_GT(over.nees_twist->mean, over.nees_twist->band_high);
  EXPECT_LT(under.nees->mean, under.nees->band_low);
}

TEST(Nees, SkipsWhatIsNoCovariance) {
  const auto truth = SmoothTruth(1, 100);
  PoseSeries estimate = SmoothSeries(0, 3, 50);
  estimate[0].covariance = StateCovariance::Identity();
  estimate[1].covariance = StateCovariance::Zero();
  estimate[2].covariance = StateCovariance::Constant(std::nan(""));
  const auto accuracy = Evaluate(estimate, truth, {});
  ASSERT_TRUE(accuracy && accuracy->nees);
  EXPECT_EQ(accuracy->nees->count, 1u);
}

}  // namespace
}  // namespace tagtwist::internal::evaluation_test
