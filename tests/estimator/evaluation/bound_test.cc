#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/evaluation/error_bound.h"
#include "estimator/graph/pose_bound.h"
#include "frontend/base/statistics/chi_square.h"
#include "frontend/geometry/pose_refine.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::bound_test {
namespace {

constexpr double kSigmaPx = 0.1;

struct View {
  EstimatorSetup setup = CourseSetup();
  Pose world_from_body = Hover({1.6, 1.3, 1.1}, 0.7, {0.25, -0.1, 0});
  std::vector<TagDetection> See(double noise_px, unsigned seed) const {
    return SeeTags(setup.map, setup.camera, setup.cam_from_body * Inverse(world_from_body),
                   noise_px, seed);
  }
};

// Least squares from the truth: the maximum of the likelihood under equal noise.
Pose Solve(const View& view, const std::vector<TagDetection>& tags) {
  std::vector<PointInImage> points;
  for (const TagDetection& tag : tags) {
    for (size_t c = 0; c < 4; ++c) {
      points.push_back({view.setup.map.CornersInWorld(tag.id)[c], tag.corners[c]});
    }
  }
  const Pose start = view.setup.cam_from_body * Inverse(view.world_from_body);
  const Pose cam_from_world = RefinePose(start, points, view.setup.camera).cam_from_world;
  return Inverse(cam_from_world) * view.setup.cam_from_body;
}

// What the bound says of single-frame solves, over many draws of the noise, with the first tags.
void ExpectBoundHolds(size_t n_tags) {
  constexpr size_t kDraws = 1500;
  const View view;
  PoseCovariance sample = PoseCovariance::Zero();
  double nees = 0;
  auto exact = view.See(0, 1);
  ASSERT_GE(exact.size(), n_tags);
  exact.resize(n_tags);
  const auto bound = PoseBound(view.setup, kSigmaPx, view.world_from_body, exact);
  ASSERT_TRUE(bound);
  for (unsigned seed = 1; seed <= kDraws; ++seed) {
    auto tags = view.See(kSigmaPx, seed);
    tags.resize(n_tags);
    const Eigen::Matrix<double, 6, 1> e =
        tagtwist::Difference({Solve(view, tags), {}}, {view.world_from_body, {}}).head<6>();
    sample += e * e.transpose() / kDraws;
    nees += e.dot(bound->llt().solve(e)) / kDraws;
  }
  const ChiSquareBand band = MeanChiSquareBand(6, kDraws, 0.999);
  EXPECT_GT(nees, band.low);
  EXPECT_LT(nees, band.high);
  for (int i = 0; i < 6; ++i) {  // a variance over n draws scatters by sqrt(2 / n)
    EXPECT_NEAR(sample(i, i) / (*bound)(i, i), 1, 4 * std::sqrt(2.0 / kDraws)) << i;
  }
}

TEST(PoseBound, IsTheCovarianceOfSolvesWithManyTags) { ExpectBoundHolds(6); }

TEST(PoseBound, IsTheCovarianceOfSolvesWithOneTag) { ExpectBoundHolds(1); }

TEST(PoseBound, GrowsWithTheNoiseAndShrinksWithTheTags) {
  const View view;
  const auto tags = view.See(0, 1);
  const auto bound = PoseBound(view.setup, kSigmaPx, view.world_from_body, tags);
  const auto noisier = PoseBound(view.setup, 3 * kSigmaPx, view.world_from_body, tags);
  auto twice = tags;
  twice.insert(twice.end(), tags.begin(), tags.end());
  const auto of_twice = PoseBound(view.setup, kSigmaPx, view.world_from_body, twice);
  ASSERT_TRUE(bound && noisier && of_twice);
  EXPECT_LT((*noisier - 9 * *bound).norm(), 1e-9 * noisier->norm());
  EXPECT_LT((*of_twice - 0.5 * *bound).norm(), 1e-9 * bound->norm());
}

TEST(PoseBound, TakesTheCornersOwnCovarianceAsTheGraphDoes) {
  const View view;
  auto tags = view.See(0, 1);
  for (TagDetection& tag : tags) {
    tag.covariance = 0.03 * 0.03 * Eigen::Matrix<double, 8, 8>::Identity();
  }
  const auto both = PoseBound(view.setup, 0.04, view.world_from_body, tags);
  for (TagDetection& tag : tags) tag.covariance.reset();
  const auto sum = PoseBound(view.setup, 0.05, view.world_from_body, tags);
  ASSERT_TRUE(both && sum);
  EXPECT_LT((*both - *sum).norm(), 1e-9 * sum->norm());
}

TEST(PoseBound, IsEmptyWhereTagsDoNotFixThePose) {
  const View view;
  EXPECT_FALSE(PoseBound(view.setup, kSigmaPx, view.world_from_body, {}));
  const Pose below = Hover({1.6, 1.3, -1.1});
  EXPECT_FALSE(PoseBound(view.setup, kSigmaPx, below, view.See(0, 1)));
}

TEST(RmsBound, IsOfThe3dStandardDeviations) {
  StateVector a, b;
  a << 1, 2, 2, 0, 3, 4, 1, 0, 0, 0, 2, 0;
  b << 0, 0, 0, 5, 0, 0, 7, 0, 0, 0, 0, 0;
  const ErrorBound bound = RmsBound(
      {StateCovariance(a.cwiseAbs2().asDiagonal()), StateCovariance(b.cwiseAbs2().asDiagonal())});
  EXPECT_EQ(bound.frames, 2u);
  EXPECT_NEAR(bound.rotation_rad, std::sqrt(4.5), 1e-12);
  EXPECT_NEAR(bound.position_m, 5, 1e-12);
  EXPECT_NEAR(bound.velocity_mps, 5, 1e-12);
  EXPECT_NEAR(bound.rate_radps, std::sqrt(2), 1e-12);
  EXPECT_EQ(RmsBound({}).frames, 0u);
}

TEST(Bounds, AreOfTheFramesAtTheLagInWindowMode) {
  Estimate e;
  e.frames.resize(3);
  for (FrameEstimate& f : e.frames) {
    f.status = FrameStatus::kOk;
    f.covariance = 4 * StateCovariance::Identity();
    f.pose_bound = 9 * PoseCovariance::Identity();
  }
  e.frames[0].status = FrameStatus::kNoFix;
  e.frames[0].pose_bound.reset();
  e.frames[1].pose_bound.reset();
  EstimateBounds bounds = BoundsOf(e);
  EXPECT_EQ(bounds.frame.frames, 1u);
  EXPECT_NEAR(bounds.frame.position_m, 3 * std::sqrt(3), 1e-12);
  EXPECT_EQ(bounds.smoothed.frames, 2u);
  EXPECT_NEAR(bounds.smoothed.rate_radps, 2 * std::sqrt(3), 1e-12);
  EXPECT_EQ(bounds.key, ComparisonKey::kOptimised);
  e.lagged = {e.frames[1]};
  bounds = BoundsOf(e);
  EXPECT_EQ(bounds.frame.frames, 0u);
  EXPECT_EQ(bounds.smoothed.frames, 1u);
  EXPECT_EQ(bounds.key, ComparisonKey::kOptimisedLagged);
}

// The law that the report tells: a long recording's sigmas against half the corner noise.
TEST(Bounds, HalfTheNoiseGainsWhatTheReportSays) {
  for (const WhiteNoiseOn on : {WhiteNoiseOn::kJerk, WhiteNoiseOn::kAcceleration}) {
    ExactModelOptions model = ModelUnder(on);
    model.linear.psd = model.angular.psd = on == WhiteNoiseOn::kJerk ? 1 : 0.01;
    model.rate_hz = 200;  // many frames smooth each other
    model.frames = 200;
    ErrorBound bounds[2];
    for (const int half : {0, 1}) {
      model.corner_sigma_px = half == 1 ? 0.075 : 0.15;
      const auto result =
          RunBatch(CourseSetUp(), GivenNoise(model), DrawFlight(model).measurements);
      ASSERT_TRUE(result) << result.error().message;
      std::vector<StateCovariance> inner;  // away from the ends
      for (size_t i = 80; i < 120; ++i) inner.push_back(result->frames[i].covariance);
      bounds[half] = RmsBound(inner);
    }
    const HalfNoiseGain gain = GainOfHalfNoise(on);
    EXPECT_NEAR(bounds[0].position_m / bounds[1].position_m, gain.pose, 0.1);
    EXPECT_NEAR(bounds[0].rotation_rad / bounds[1].rotation_rad, gain.pose, 0.1);
    EXPECT_NEAR(bounds[0].velocity_mps / bounds[1].velocity_mps, gain.twist, 0.1);
    EXPECT_NEAR(bounds[0].rate_radps / bounds[1].rate_radps, gain.twist, 0.1);
  }
}

}  // namespace
}  // namespace tagtwist::internal::bound_test
