#include "estimator/solve/frame_chain.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/graph/noise_model.h"
#include "estimator/start/recording_start.h"
#include "tests/support/exact_model.h"

namespace tagtwist {
namespace {

// A flight at its start, its noise open.
struct Case {
  EstimatorSetup setup = CourseSetup();
  NoiseModel noise;
  GraphInput input;

  explicit Case(WhiteNoiseOn prior) : noise(InitialNoise(setup.options, prior)) {
    input.frames = *StartFrames(setup, DrawFlight(ModelUnder(prior, 5)).measurements);
  }
  void MisplaceTags() {
    for (size_t i = 3; i < input.frames.size(); i += 7) {
      for (Eigen::Vector2d& corner : input.frames[i].tags.front().corners) corner.y() -= 3;
    }
  }
  void GiveCornersCovariances() {
    for (GraphFrame& frame : input.frames) {
      for (TagDetection& tag : frame.tags) {
        tag.covariance.emplace(0.01 * (tag.id % 3 + 1) * Eigen::Matrix<double, 8, 8>::Identity());
        (*tag.covariance)(0, 2) = (*tag.covariance)(2, 0) = 0.005;
      }
    }
  }
};

void ExpectNear(const VarianceStatistic& a, const VarianceStatistic& b) {
  EXPECT_NEAR(a.sum, b.sum, 1e-4 * b.sum);
  EXPECT_NEAR(a.dof, b.dof, 1e-4 * b.dof + 1e-4);
}

// The chain's solution, statistics and likelihood are the graph's.
void ExpectSameAsGraph(FrameChain* chain, const Case& c, const NoiseModel& noise) {
  const auto of_chain = chain->Solve(noise, {50}, 0);
  const auto of_graph = SolveAndInvert(c.setup, noise, c.input, {50});
  ASSERT_TRUE(of_chain && of_graph);
  EXPECT_NEAR(of_chain->cost, of_graph->cost, 1e-7 * of_graph->cost);
  EXPECT_NEAR(of_chain->log_likelihood, of_graph->log_likelihood,
              1e-8 * std::abs(of_graph->log_likelihood));
  for (size_t i = 0; i < c.input.frames.size(); ++i) {
    const int k = static_cast<int>(i);
    const StateCovariance p = BodyCovariance(of_graph->covariance, k);
    const StateVector d =
        Difference(ToBodyState(of_chain->graph.states[i]), ToBodyState(of_graph->graph.states[i]));
    EXPECT_LT(std::sqrt(d.dot(p.llt().solve(d))), 1e-4) << i;
    EXPECT_LT((BodyCovariance(of_chain->covariance, k) - p).norm(), 1e-4 * p.norm()) << i;
  }
  const NoiseStatistics a = chain->Statistics(of_chain->covariance),
                        b = ComputeNoiseStatistics(of_graph->graph, of_graph->covariance, noise,
                                                   {0, static_cast<int>(c.input.frames.size())});
  ExpectNear(a.corner, b.corner);
  ExpectNear(a.linear, b.linear);
  ExpectNear(a.angular, b.angular);
  EXPECT_DOUBLE_EQ(a.motions, b.motions);
  EXPECT_DOUBLE_EQ(a.motion_s, b.motion_s);
}

class FrameChainTest : public UnderBothPriors {};
INSTANTIATE_UNDER_BOTH_PRIORS(FrameChainTest);

// Under one noise and then another: forms are taken over where they may be.
TEST_P(FrameChainTest, EndsWhereTheGraphDoes) {
  const Case c(GetParam());
  FrameChain chain(c.setup, c.input);
  ExpectSameAsGraph(&chain, c, c.noise);
  NoiseModel other = c.noise;
  other.corner_sigma_px *= 0.4;
  other.linear.psd *= 0.1;
  ExpectSameAsGraph(&chain, c, other);
}

TEST_P(FrameChainTest, EndsWhereTheGraphDoesBesideWrongTagsAndAGap) {
  Case c(GetParam());
  c.MisplaceTags();
  for (size_t i = 20; i < 30; ++i) c.input.frames[i].tags.clear();
  FrameChain chain(c.setup, c.input);
  ExpectSameAsGraph(&chain, c, c.noise);
  NoiseModel other = c.noise;
  other.corner_sigma_px *= 3;  // the wrong tags are hardly wrong any more
  ExpectSameAsGraph(&chain, c, other);
}

TEST_P(FrameChainTest, EndsWhereTheGraphDoesWithCovariancesOfTheCornersOwn) {
  Case c(GetParam());
  c.GiveCornersCovariances();
  c.MisplaceTags();
  FrameChain chain(c.setup, c.input);
  ExpectSameAsGraph(&chain, c, c.noise);
  NoiseModel other = c.noise;
  other.corner_sigma_px *= 0.3;
  ExpectSameAsGraph(&chain, c, other);
}

// Where forms are kept while poses move, the solution is that of all factors to a fraction of a
// standard deviation.
TEST_P(FrameChainTest, WhatIsNeglectedDoesNotShow) {
  const Case c(GetParam());
  FrameChain chain(c.setup, c.input);
  const auto coarse = chain.Solve(c.noise, {50, 1e-4}, 1e-2);
  const auto fine = SolveAndInvert(c.setup, c.noise, c.input, {50});
  ASSERT_TRUE(coarse && fine);
  for (size_t i = 0; i < c.input.frames.size(); ++i) {
    const StateVector d =
        Difference(ToBodyState(coarse->graph.states[i]), ToBodyState(fine->graph.states[i]));
    const StateCovariance p = BodyCovariance(fine->covariance, static_cast<int>(i));
    EXPECT_LT(std::sqrt(d.dot(p.llt().solve(d))), 0.1) << i;
  }
}

TEST(FrameChain, LeavesTracksPriorsAndHardStartsToTheGraph) {
  Case c(WhiteNoiseOn::kJerk);
  EXPECT_TRUE(FrameChain::Fits(c.setup, c.input));
  GraphInput with_track = c.input;
  with_track.segments.emplace_back();
  EXPECT_FALSE(FrameChain::Fits(c.setup, with_track));
  GraphInput with_prior = c.input;
  with_prior.prior.emplace();
  EXPECT_FALSE(FrameChain::Fits(c.setup, with_prior));
  Pose& pose = c.input.frames[4].state.world_from_body;
  pose = MakePose(pose.rotation(), {0, 0, -1});  // under the mat
  EXPECT_FALSE(FrameChain(c.setup, c.input).Solve(c.noise, {50}, 0));
}

}  // namespace
}  // namespace tagtwist
