#include <ceres/sized_cost_function.h>
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <memory>

#include "estimator/graph/marginalisation.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/start/recording_start.h"
#include "estimator/window/window_hypothesis.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::other_factor_test {
namespace {

constexpr double kSigmaM = 2e-4;  // far better than the tags
constexpr double kOffsetM = 0.002;

// A height of the body over the map, measured by something: no file of the library knows of it.
class HeightResidual final : public ceres::SizedCostFunction<1, 7> {
 public:
  explicit HeightResidual(double height_m) : height_m_(height_m) {}
  bool Evaluate(double const* const* pose, double* residual, double** jacobian) const override {
    residual[0] = (pose[0][6] - height_m_) / kSigmaM;
    if (jacobian == nullptr || jacobian[0] == nullptr) return true;
    Eigen::Map<Eigen::Matrix<double, 1, 7>> row(jacobian[0]);
    row.setZero();
    row(6) = 1 / kSigmaM;
    return true;
  }

 private:
  double height_m_;
};

// A climb since the frame before the last: between states that are no neighbours, and by the rates.
class ClimbResidual final : public ceres::SizedCostFunction<2, 7, 7, 12> {
 public:
  ClimbResidual(double climb_m, double rate_mps) : climb_m_(climb_m), rate_mps_(rate_mps) {}
  bool Evaluate(double const* const* blocks, double* residual, double** jacobians) const override {
    residual[0] = (blocks[1][6] - blocks[0][6] - climb_m_) / kSigmaM;
    residual[1] = (blocks[2][2] - rate_mps_) / 0.01;
    if (jacobians == nullptr) return true;
    for (int i = 0; i < 2; ++i) {
      if (jacobians[i] == nullptr) continue;
      Eigen::Map<Eigen::Matrix<double, 2, 7, Eigen::RowMajor>> by_pose(jacobians[i]);
      by_pose.setZero();
      by_pose(0, 6) = (i == 0 ? -1 : 1) / kSigmaM;
    }
    if (jacobians[2] != nullptr) {
      Eigen::Map<Eigen::Matrix<double, 2, 12, Eigen::RowMajor>> by_rates(jacobians[2]);
      by_rates.setZero();
      by_rates(1, 2) = 1 / 0.01;
    }
    return true;
  }

 private:
  double climb_m_, rate_mps_;
};

Factor Height(double height_m) {
  Factor factor;
  factor.kind = FactorKind::kOther;
  factor.blocks = {{BlockRef::Kind::kPose, 0}};
  factor.cost = std::make_shared<HeightResidual>(height_m);
  return factor;
}

Factor Climb(double climb_m, double rate_mps) {
  Factor factor;
  factor.kind = FactorKind::kOther;
  factor.blocks = {
      {BlockRef::Kind::kPose, -2}, {BlockRef::Kind::kPose, 0}, {BlockRef::Kind::kRates, 0}};
  factor.cost = std::make_shared<ClimbResidual>(climb_m, rate_mps);
  return factor;
}

// A flight whose frames 3, 6, ... were also measured by those, the heights off by kOffsetM.
struct Case {
  EstimatorSetup setup;
  NoiseModel noise;
  GraphInput input;

  explicit Case(bool measured, bool given = true)
      : setup(CourseSetup(given ? GivenNoise(ModelUnder(WhiteNoiseOn::kJerk, 3))
                                : EstimatorOptions())),
        noise(InitialNoise(setup.options)) {
    const ExactModelFlight flight = DrawFlight(ModelUnder(WhiteNoiseOn::kJerk, 3));
    input.frames = *StartFrames(setup, flight.measurements);
    for (size_t k = 3; measured && k < input.frames.size(); k += 3) {
      const auto height = [&](size_t i) {
        return flight.truth[i].world_from_body.translation().z();
      };
      input.frames[k].others = {
          Height(height(k) + kOffsetM),
          Climb(height(k) - height(k - 2), flight.truth[k].twist.v_world.z())};
    }
  }
};

double SigmaOfHeight(const Solution& solution, int k) {
  return std::sqrt(BodyCovariance(solution.covariance, k)(5, 5));
}

void ExpectSame(const Solution& a, const Solution& b) {
  ASSERT_EQ(a.graph.states.size(), b.graph.states.size());
  for (size_t i = 0; i < a.graph.states.size(); ++i) {
    const int k = static_cast<int>(i);
    const StateCovariance p = BodyCovariance(b.covariance, k);
    const StateVector d =
        Difference(ToBodyState(a.graph.states[i]), ToBodyState(b.graph.states[i]));
    EXPECT_LT(std::sqrt(d.dot(p.llt().solve(d))), 0.02) << i;
    EXPECT_LT((BodyCovariance(a.covariance, k) - p).norm(), 1e-2 * p.norm()) << i;
  }
}

// Of a batch, whether its noise is given or learned, in the chain or in the graph, by Ceres or not.
TEST(OtherFactor, IsInTheBatchAndInItsCovariance) {
  for (const bool given : {true, false}) {
    Case with(true, given), without(false, given);
    const auto solved = SolveAndLearn(with.setup, {50}, &with.input, &with.noise);
    const auto plain = SolveAndLearn(without.setup, {50}, &without.input, &without.noise);
    ASSERT_TRUE(solved && plain);
    const auto whole = SolveAndInvert(with.setup, with.noise, with.input, {50});
    with.setup.options.solver = Solver::kCeres;
    const auto by_ceres = SolveAndInvert(with.setup, with.noise, with.input, {50});
    ASSERT_TRUE(whole && by_ceres);
    ExpectSame(*solved, *whole);
    ExpectSame(*solved, *by_ceres);
    for (const int k : {12, 30}) {
      EXPECT_LT(SigmaOfHeight(*solved, k), 1.01 * kSigmaM);
      EXPECT_GT(SigmaOfHeight(*plain, k), 1.5 * kSigmaM);
      const auto i = static_cast<size_t>(k);
      const double moved = solved->graph.states[i].pose.translation().z() -
                           plain->graph.states[i].pose.translation().z();
      EXPECT_GT(moved, 0.5 * kOffsetM);
    }
  }
}

// Runs a window over the frames, by steps or whole, each state marginalised in its turn.
Solution RunHypothesis(const Case& c, bool steps) {
  constexpr size_t kWindow = 8;
  WindowHypothesis window;
  for (const GraphFrame& frame : c.input.frames) {
    window.input.frames.push_back(frame);
    const size_t size = window.input.frames.size();
    if (size < 4) continue;  // a climb needs the frames before it
    EXPECT_TRUE(steps ? StepHypothesis(c.setup, c.noise, {20}, &window)
                      : SolveHypothesis(c.setup, c.noise, {20}, &window));
    if (size == kWindow) MarginalizeOldest(&window);
  }
  return std::move(window.solution);
}

// What has left keeps its say: the prior holds it, whatever states it touched.
TEST(OtherFactor, IsInTheWindowAndInWhatLeavesIt) {
  const Case with(true), without(false);
  const Solution stepped = RunHypothesis(with, true), whole = RunHypothesis(with, false);
  const auto batch = SolveAndInvert(with.setup, with.noise, with.input, {50});
  ASSERT_TRUE(batch);
  ExpectSame(stepped, whole);
  const int newest = stepped.covariance.size() - 1;
  const int in_batch = batch->covariance.size() - 1;
  EXPECT_NEAR(SigmaOfHeight(stepped, newest), SigmaOfHeight(*batch, in_batch),
              0.01 * SigmaOfHeight(*batch, in_batch));
  const Solution plain = RunHypothesis(without, true);
  EXPECT_GT(SigmaOfHeight(plain, newest), 1.5 * SigmaOfHeight(stepped, newest));
}

}  // namespace
}  // namespace tagtwist::internal::other_factor_test
