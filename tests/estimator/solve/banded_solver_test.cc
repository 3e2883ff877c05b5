#include "estimator/solve/banded_solver.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/linear_system.h"
#include "estimator/graph/noise_model.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/start/recording_start.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::banded_solver_test {
namespace {

// The graph of a flight at its start.
struct Case {
  EstimatorSetup setup;
  NoiseModel noise;
  GraphInput input;

  explicit Case(WhiteNoiseOn prior) : setup(CourseSetup(GivenNoise(ModelUnder(prior, 5)))) {
    noise = InitialNoise(setup.options);
    input.frames = *StartFrames(setup, DrawFlight(ModelUnder(prior, 5)).measurements);
  }
  Graph MakeGraph() const { return BuildGraph(setup, noise, input); }
};

// By Ceres and by bands, from the same start: the same cost, and states that are far less than a
// standard deviation apart.
void ExpectSameAsCeres(const Graph& start) {
  Graph by_ceres = start, by_bands = start;
  const SolveSummary ceres = Solve({100}, &by_ceres);
  const BandedSolution bands = SolveBanded({100}, &by_bands);
  ASSERT_TRUE(ceres.usable && bands.summary.usable && bands.normal_equations);
  EXPECT_NEAR(bands.summary.final_cost, ceres.final_cost, 1e-8 * ceres.final_cost);
  const BlockBandedCholesky cholesky(Linearize(by_ceres).hessian);
  ASSERT_TRUE(cholesky.ok());
  const BlockBandedMatrix p = cholesky.SelectedInverse(),
                          p_bands = bands.normal_equations->SelectedInverse();
  for (size_t i = 0; i < start.states.size(); ++i) {
    const int k = static_cast<int>(i);
    const StateCovariance covariance = p.At(k, k).topLeftCorner<12, 12>();
    const StateVector d =
        Difference(ToBodyState(by_bands.states[i]), ToBodyState(by_ceres.states[i]));
    EXPECT_LT(std::sqrt(d.dot(covariance.llt().solve(d))), 1e-5) << i;
    EXPECT_LT((p_bands.At(k, k) - p.At(k, k)).norm(), 1e-5 * p.At(k, k).norm()) << i;
  }
}

class BandedSolverTest : public UnderBothPriors {};
INSTANTIATE_UNDER_BOTH_PRIORS(BandedSolverTest);

TEST_P(BandedSolverTest, EndsWhereCeresDoes) { ExpectSameAsCeres(Case(GetParam()).MakeGraph()); }

TEST_P(BandedSolverTest, EndsWhereCeresDoesBesideWrongTagsAndAGap) {
  Case c(GetParam());
  for (size_t i = 3; i < c.input.frames.size(); i += 7) {
    for (Eigen::Vector2d& corner : c.input.frames[i].tags.front().corners) corner.y() -= 3;
  }
  for (size_t i = 20; i < 30; ++i) c.input.frames[i].tags.clear();
  ExpectSameAsCeres(c.MakeGraph());
}

TEST_P(BandedSolverTest, FindsTheWayFromAPoorStart) {
  Case c(GetParam());
  Graph near = c.MakeGraph();
  for (size_t i = 0; i < c.input.frames.size(); ++i) {
    BodyState& state = c.input.frames[i].state;
    const double sign = i % 2 == 0 ? 1 : -1;
    state.world_from_body =
        MakePose(state.world_from_body.rotation() *
                     Eigen::AngleAxisd(sign * 0.15, Eigen::Vector3d(1, 2, 3).normalized()),
                 state.world_from_body.translation() + Eigen::Vector3d(0.1, -0.1, sign * 0.1));
  }
  Graph far = c.MakeGraph();
  const BandedSolution from_near = SolveBanded({100}, &near), from_far = SolveBanded({100}, &far);
  ASSERT_TRUE(from_near.summary.usable && from_far.summary.usable);
  EXPECT_GT(from_far.summary.iterations, from_near.summary.iterations);
  EXPECT_NEAR(from_far.summary.final_cost, from_near.summary.final_cost,
              1e-8 * from_near.summary.final_cost);
}

// Between two poses of one tag seen nearly face-on a full step overshoots.
TEST(BandedSolver, LowersTheCostWhereAFullStepWouldRaiseIt) {
  Case c(WhiteNoiseOn::kJerk);
  c.input.frames.resize(1);
  c.input.frames[0].tags.resize(1);
  c.input.frames[0].state.world_from_body =
      MakePose(c.input.frames[0].state.world_from_body.rotation() *
                   Eigen::AngleAxisd(0.9, Eigen::Vector3d::UnitX()),
               c.input.frames[0].state.world_from_body.translation());
  const Graph start = c.MakeGraph();
  Graph solved = start, full_step = start;
  const BlockBandedCholesky cholesky(Linearize(start).hessian);
  ASSERT_TRUE(cholesky.ok());
  full_step.states[0] = Retract(start.states[0], cholesky.Solve(-Linearize(start).gradient));
  const LinearSystem after_full_step = Linearize(full_step);
  ASSERT_FALSE(after_full_step.is_whole && after_full_step.cost < Linearize(start).cost);
  for (int n = 1; n < 6; ++n) {
    Graph stopped = start;
    SolveBanded({n}, &stopped);
    EXPECT_LE(Linearize(stopped).cost, Linearize(start).cost) << n << " iterations";
  }
  const BandedSolution bands = SolveBanded({200}, &solved);
  ASSERT_TRUE(bands.summary.usable);
  EXPECT_LT(bands.summary.final_cost, 0.1 * Linearize(start).cost);
  EXPECT_LT(Linearize(solved).gradient.norm(), 1e-6 * Linearize(start).gradient.norm());
}

TEST(BandedSolver, StopsAfterTheGivenIterations) {
  Graph graph = Case(WhiteNoiseOn::kJerk).MakeGraph();
  const double cost = Linearize(graph).cost;
  const BandedSolution bands = SolveBanded({1}, &graph);
  ASSERT_TRUE(bands.summary.usable && bands.normal_equations);
  EXPECT_EQ(bands.summary.iterations, 1);
  EXPECT_LT(bands.summary.final_cost, cost);
  EXPECT_DOUBLE_EQ(bands.summary.final_cost, Linearize(graph).cost);
}

TEST(BandedSolver, StopsInTimeWithTheBestSoFar) {
  Graph graph = Case(WhiteNoiseOn::kJerk).MakeGraph();
  const double cost = Linearize(graph).cost;
  const BandedSolution bands = SolveBanded({100, 1e-13, [] { return true; }}, &graph);
  ASSERT_TRUE(bands.summary.usable && bands.normal_equations);
  EXPECT_EQ(bands.summary.iterations, 1);
  EXPECT_LT(bands.summary.final_cost, cost);
}

TEST(BandedSolver, RefusesStatesWhereAFactorCannotBeEvaluated) {
  Graph graph = Case(WhiteNoiseOn::kJerk).MakeGraph();
  graph.states[4].pose = MakePose(graph.states[4].pose.rotation(), {0, 0, -1});  // under the mat
  const BandedSolution bands = SolveBanded({10}, &graph);
  EXPECT_FALSE(bands.summary.usable);
  EXPECT_NE(bands.summary.message.find("cannot be evaluated"), std::string::npos);
}

// What failed is named: the state that nothing ties, not some matrix.
TEST(BandedSolver, NamesTheStateThatNothingTies) {
  Graph graph = Case(WhiteNoiseOn::kJerk).MakeGraph();
  const auto touches_last = [&](const Factor& factor) {
    return factor.blocks.back().index + 1 == static_cast<int>(graph.states.size());
  };
  graph.factors.erase(std::remove_if(graph.factors.begin(), graph.factors.end(), touches_last),
                      graph.factors.end());
  const BandedSolution bands = SolveBanded({10}, &graph);
  EXPECT_FALSE(bands.summary.usable);
  EXPECT_NE(bands.summary.message.find("not positive definite at state 60 of 60"),
            std::string::npos)
      << bands.summary.message;
  EXPECT_NE(bands.summary.message.find(std::to_string(graph.states.back().t_ns) + " ns"),
            std::string::npos);
}

TEST(BandedSolver, NamesACostWithoutAValue) {
  Graph graph = Case(WhiteNoiseOn::kJerk).MakeGraph();
  graph.states[3].rates.setConstant(std::numeric_limits<double>::quiet_NaN());
  const BandedSolution bands = SolveBanded({10}, &graph);
  EXPECT_FALSE(bands.summary.usable);
  EXPECT_NE(bands.summary.message.find("no value"), std::string::npos) << bands.summary.message;
}

// Frames of one time are a broken promise, which is named, with the stamp; they used to end as
// normal equations that are not positive definite.
TEST(BandedSolver, AGraphOfAStampTwiceIsNoGraph) {
  Case c(WhiteNoiseOn::kJerk);
  c.input.frames[7].t_ns = c.input.frames[6].t_ns;
  try {
    c.MakeGraph();
    FAIL() << "a graph was made";
  } catch (const std::logic_error& error) {
    const std::string stamp = std::to_string(c.input.frames[6].t_ns);
    EXPECT_NE(std::string(error.what()).find("stamps grow, but " + stamp), std::string::npos)
        << error.what();
  }
}

TEST(BandedSolver, TakesNoPoints) {
  Graph graph = Case(WhiteNoiseOn::kJerk).MakeGraph();
  EXPECT_TRUE(IsBanded(graph));
  graph.points.emplace_back(0, 0);
  EXPECT_FALSE(IsBanded(graph));
}

}  // namespace
}  // namespace tagtwist::internal::banded_solver_test
