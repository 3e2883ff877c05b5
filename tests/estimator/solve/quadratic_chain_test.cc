#include "estimator/solve/quadratic_chain.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/graph/noise_model.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/noise_statistics.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/recording_start.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::quadratic_chain_test {
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
  QuadraticChain Chain() const { return QuadraticChain(BuildGraph(setup, noise, input)); }
};

void ExpectNear(const VarianceStatistic& a, const VarianceStatistic& b) {
  EXPECT_NEAR(a.sum, b.sum, 1e-4 * b.sum);
  EXPECT_NEAR(a.dof, b.dof, 1e-4 * b.dof + 1e-4);
}

// Under that noise the chain's solution, statistics and likelihood are the graph's.
void ExpectSameAsGraph(QuadraticChain* chain, const Case& c, const NoiseModel& noise) {
  chain->ChangeFactors([&](const Graph& graph, Factor* factor) {
    SetNoise(c.setup, noise, c.input, graph, factor);
  });
  const auto of_chain = chain->Solve({50}, {});
  const auto of_graph = SolveAndInvert(c.setup, noise, c.input, {50});
  ASSERT_TRUE(of_chain && of_graph);
  EXPECT_NEAR(of_chain->cost, of_graph->cost, 1e-7 * of_graph->cost);
  EXPECT_NEAR(of_chain->log_likelihood, of_graph->log_likelihood,
              1e-8 * std::abs(of_graph->log_likelihood));
  for (size_t i = 0; i < c.input.frames.size(); ++i) {
    const int k = static_cast<int>(i);
    const StateCovariance p = BodyCovariance(of_graph->covariance, k);
    const StateVector d =
        Difference(ToBodyState(chain->graph().states[i]), ToBodyState(of_graph->graph.states[i]));
    EXPECT_LT(std::sqrt(d.dot(p.llt().solve(d))), 1e-4) << i;
    EXPECT_LT((BodyCovariance(of_chain->covariance, k) - p).norm(), 1e-4 * p.norm()) << i;
  }
  const NoiseStatistics a = ComputeNoiseStatistics(*chain, of_chain->covariance, noise, InOneRange),
                        b = ComputeNoiseStatistics(of_graph->graph, of_graph->covariance, noise,
                                                   {0, static_cast<int>(c.input.frames.size())});
  ExpectNear(a.corner, b.corner);
  ExpectNear(a.linear, b.linear);
  ExpectNear(a.angular, b.angular);
  EXPECT_DOUBLE_EQ(a.motions, b.motions);
  EXPECT_DOUBLE_EQ(a.motion_s, b.motion_s);
}

class QuadraticChainTest : public UnderBothPriors {};
INSTANTIATE_UNDER_BOTH_PRIORS(QuadraticChainTest);

// Under one noise and then another: forms are taken over where they may be.
TEST_P(QuadraticChainTest, EndsWhereTheGraphDoes) {
  const Case c(GetParam());
  QuadraticChain chain = c.Chain();
  ExpectSameAsGraph(&chain, c, c.noise);
  NoiseModel other = c.noise;
  other.corner_sigma_px *= 0.4;
  other.linear.psd *= 0.1;
  ExpectSameAsGraph(&chain, c, other);
}

TEST_P(QuadraticChainTest, EndsWhereTheGraphDoesBesideWrongTagsAndAGap) {
  Case c(GetParam());
  c.MisplaceTags();
  for (size_t i = 20; i < 30; ++i) c.input.frames[i].tags.clear();
  QuadraticChain chain = c.Chain();
  ExpectSameAsGraph(&chain, c, c.noise);
  NoiseModel other = c.noise;
  other.corner_sigma_px *= 3;  // the wrong tags are hardly wrong any more
  ExpectSameAsGraph(&chain, c, other);
}

// Of a frame that was solved for, all tags may turn out to be wrong.
TEST_P(QuadraticChainTest, EndsWhereTheGraphDoesWithTheTagsOfFramesTakenAway) {
  Case c(GetParam());
  QuadraticChain chain = c.Chain();
  ExpectSameAsGraph(&chain, c, c.noise);
  for (const int k : {0, 20, 21}) {
    c.input.frames[static_cast<size_t>(k)].tags.clear();
    chain.ReplaceFactorsOfPose(k, {});
  }
  NoiseModel other = c.noise;
  other.corner_sigma_px *= 0.4;
  ExpectSameAsGraph(&chain, c, other);
}

TEST_P(QuadraticChainTest, EndsWhereTheGraphDoesWithCovariancesOfTheCornersOwn) {
  Case c(GetParam());
  c.GiveCornersCovariances();
  c.MisplaceTags();
  QuadraticChain chain = c.Chain();
  ExpectSameAsGraph(&chain, c, c.noise);
  NoiseModel other = c.noise;
  other.corner_sigma_px *= 0.3;
  ExpectSameAsGraph(&chain, c, other);
}

// Where forms are kept while poses move, the solution is that of all factors to a fraction of a
// standard deviation.
TEST_P(QuadraticChainTest, WhatIsNeglectedDoesNotShow) {
  const Case c(GetParam());
  QuadraticChain chain = c.Chain();
  const auto coarse = chain.Solve({50, 1e-4}, {1e-2, false});
  const auto fine = SolveAndInvert(c.setup, c.noise, c.input, {50});
  ASSERT_TRUE(coarse && fine);
  for (size_t i = 0; i < c.input.frames.size(); ++i) {
    const StateVector d =
        Difference(ToBodyState(chain.graph().states[i]), ToBodyState(fine->graph.states[i]));
    const StateCovariance p = BodyCovariance(fine->covariance, static_cast<int>(i));
    EXPECT_LT(std::sqrt(d.dot(p.llt().solve(d))), 0.1) << i;
  }
}

// Work that is split gives the same bits however it is split.
TEST(QuadraticChain, IsTheSameInAnyRanges) {
  const Case c(WhiteNoiseOn::kJerk);
  const auto solve = [&](const ForRanges& for_ranges) {
    QuadraticChain chain(BuildGraph(c.setup, c.noise, c.input), for_ranges);
    EXPECT_TRUE(chain.Solve({50}, {}));
    return chain.graph().states;
  };
  const auto in_sevens = [](size_t count, const std::function<void(size_t, size_t)>& work) {
    for (size_t last = count; last > 0; last = last > 7 ? last - 7 : 0) {
      work(last > 7 ? last - 7 : 0, last);
    }
  };
  const std::vector<GraphState> whole = solve(InOneRange), split = solve(in_sevens);
  for (size_t k = 0; k < whole.size(); ++k) {
    EXPECT_EQ(whole[k].pose.params, split[k].pose.params);
    EXPECT_EQ(whole[k].rates, split[k].rates);
  }
}

TEST(QuadraticChain, SaysWhereFullStepsDoNotDo) {
  Case c(WhiteNoiseOn::kJerk);
  Pose& pose = c.input.frames[4].state.world_from_body;
  Graph graph = BuildGraph(c.setup, c.noise, c.input);
  graph.states[4].pose = MakePose(pose.rotation(), {0, 0, -1});  // under the mat
  const auto solved = QuadraticChain(graph).Solve({50}, {});
  ASSERT_FALSE(solved);
  EXPECT_NE(solved.error().message.find("cannot be evaluated"), std::string::npos);
  pose = graph.states[4].pose;
  EXPECT_GT(BuildGraph(c.setup, c.noise, c.input).n_left_out, 0);
}

TEST(QuadraticChain, TakesNoPointsAndNoStampTwice) {
  Graph graph = Case(WhiteNoiseOn::kJerk).Chain().graph();
  QuadraticChain chain(graph);
  EXPECT_THROW(chain.AddState(graph.states.back()), std::logic_error);
  graph.points.emplace_back(0.1, 0.2);
  EXPECT_FALSE(QuadraticChain::Fits(graph));
  EXPECT_THROW(QuadraticChain{graph}, std::logic_error);
}

}  // namespace
}  // namespace tagtwist::internal::quadratic_chain_test
