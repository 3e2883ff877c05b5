#include "estimator/graph/marginalisation.h"

#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <memory>

#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"
#include "estimator/solve/ceres_solver.h"
#include "residuals/motion_residual.h"
#include "residuals/prior_residual.h"

namespace tagtwist::internal::marginalisation_test {
namespace {

constexpr int kStates = 9;
const SolveOptions kExact{50, 0.0};

// Position and attitude measured at every state, no rotation: a linear problem.
Factor Measurement(int state, const Eigen::Vector3d& position) {
  PriorBlock block{true, MakePose(Eigen::Quaterniond::Identity(), position).params};
  Factor factor;
  factor.kind = FactorKind::kPrior;
  factor.blocks = {{BlockRef::Kind::kPose, state}};
  factor.cost = std::make_shared<PriorResidual>(std::vector<PriorBlock>{block},
                                                20.0 * Eigen::MatrixXd::Identity(6, 6),
                                                Eigen::VectorXd::Zero(6));
  return factor;
}

Factor Motion(int state) {
  Factor factor;
  factor.kind = FactorKind::kMotion;
  using Kind = BlockRef::Kind;
  factor.blocks = {{Kind::kPose, state},
                   {Kind::kRates, state},
                   {Kind::kPose, state + 1},
                   {Kind::kRates, state + 1}};
  factor.cost =
      std::make_shared<MotionResidual>(0.1 + 0.02 * state, MotionPrior{WhiteNoiseOn::kJerk, 2.0},
                                       MotionPrior{WhiteNoiseOn::kJerk, 1.0});
  return factor;
}

Eigen::Vector3d MeasuredPosition(int state) {
  return {0.3 * state, std::sin(1.7 * state), 0.1 * state * state};
}

Graph LinearGraph() {
  Graph graph;
  graph.states.resize(kStates);
  for (int i = 0; i < kStates; ++i) {
    graph.factors.push_back(Measurement(i, MeasuredPosition(i)));
    if (i + 1 < kStates) graph.factors.push_back(Motion(i));
  }
  return graph;
}

// The same graph, its states coming one by one, all but the last two marginalised on the way.
Graph WindowOfTwo() {
  Graph graph;
  graph.states.resize(1);
  graph.factors = {Measurement(0, MeasuredPosition(0))};
  for (int i = 1; i < kStates; ++i) {
    const int newest = static_cast<int>(graph.states.size());
    graph.states.push_back(graph.states.back());
    Factor motion = Motion(i - 1);
    for (BlockRef& block : motion.blocks) block.index += newest - i;
    graph.factors.push_back(motion);
    graph.factors.push_back(Measurement(newest, MeasuredPosition(i)));
    EXPECT_TRUE(Solve(kExact, &graph).usable);
    if (newest < 2 || i + 1 == kStates) continue;
    const std::vector<bool> used = UsedByMarginalisation(graph);
    std::vector<Factor> kept = {*MarginalizeFirstState(graph)};
    for (size_t f = 0; f < graph.factors.size(); ++f) {
      if (used[f]) continue;
      kept.push_back(graph.factors[f]);
      for (BlockRef& block : kept.back().blocks) --block.index;
    }
    graph.factors = std::move(kept);
    graph.states.erase(graph.states.begin());
  }
  return graph;
}

TEST(Marginalisation, AWindowAgreesWithTheWholeProblemWhereItIsLinear) {
  Graph full = LinearGraph();
  ASSERT_TRUE(Solve(kExact, &full).usable);
  const Graph window = WindowOfTwo();
  const GraphState &a = full.states.back(), &b = window.states.back();
  EXPECT_LT((a.pose.params - b.pose.params).norm(), 1e-9);
  EXPECT_LT((a.rates - b.rates).norm(), 1e-9);
  const BlockBandedMatrix p_full = BlockBandedCholesky(Linearize(full).hessian).SelectedInverse();
  const BlockBandedMatrix p_window =
      BlockBandedCholesky(Linearize(window).hessian).SelectedInverse();
  const int last = static_cast<int>(window.states.size()) - 1;
  EXPECT_LT((p_full.At(kStates - 1, kStates - 1) - p_window.At(last, last)).norm(),
            1e-9 * p_full.At(kStates - 1, kStates - 1).norm());
}

TEST(Marginalisation, DroppingInsteadOfMarginalisingWouldShow) {
  Graph full = LinearGraph(), cut = LinearGraph();
  ASSERT_TRUE(Solve(kExact, &full).usable);
  cut.factors.erase(cut.factors.begin(), cut.factors.begin() + 12);  // what touches states 0 to 5
  for (Factor& factor : cut.factors) {
    for (BlockRef& block : factor.blocks) block.index -= 6;
  }
  cut.states.resize(kStates - 6);
  ASSERT_TRUE(Solve(kExact, &cut).usable);
  EXPECT_GT((full.states.back().rates - cut.states.back().rates).norm(), 1e-3);
}

// Two residuals of a pose and a point of which the point shows along one direction alone, as on a
// plane seen edge-on.
class EdgeOn final : public ceres::SizedCostFunction<2, 7, 2> {
 public:
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    residual[0] = blocks[0][4] + blocks[1][0] + blocks[1][1];
    residual[1] = blocks[0][5];
    if (jacobians == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> by_pose(jacobians[0]);
    Eigen::Map<Eigen::Matrix<double, 2, 2, Eigen::RowMajor>> by_point(jacobians[1]);
    by_pose.setZero();
    by_pose(0, 4) = by_pose(1, 5) = 1;
    by_point << 1, 1, 0, 0;
    return true;
  }
};

// A point takes what its view says of it, even where that leaves a direction of it open: the pose
// is not known as though the point were.
TEST(Marginalisation, AnOpenPointTiesNoPose) {
  Graph graph;
  graph.states.resize(1);
  graph.points.emplace_back(0, 0);
  Factor view;
  view.kind = FactorKind::kTrack;
  view.blocks = {{BlockRef::Kind::kPose, 0}, {BlockRef::Kind::kPoint, 0}};
  view.cost = std::make_shared<EdgeOn>();
  graph.factors = {view};
  const BlockBandedMatrix::Block hessian = Linearize(graph).hessian.At(0, 0);
  EXPECT_NEAR(hessian(3, 3), 0, 1e-12);  // x: the point's to explain
  EXPECT_NEAR(hessian(4, 4), 1, 1e-12);
}

}  // namespace
}  // namespace tagtwist::internal::marginalisation_test
