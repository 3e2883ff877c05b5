#include "estimator/trajectory.h"

#include <gtest/gtest.h>

#include "estimator/batch.h"
#include "tests/exact_model.h"

namespace tagtwist {
namespace {

EstimatorSetup SetupFor(const ExactModelOptions& model) { return CourseSetup(GivenNoise(model)); }

class TrajectoryTest : public testing::TestWithParam<WhiteNoiseOn> {
 protected:
  static ExactModelOptions Model() {
    const ExactModelOptions model;
    return GetParam() == WhiteNoiseOn::kJerk ? model : WithWhiteAcceleration(model);
  }
};
INSTANTIATE_TEST_SUITE_P(Priors, TrajectoryTest,
                         testing::Values(WhiteNoiseOn::kAcceleration, WhiteNoiseOn::kJerk),
                         PriorName);

// A frame without tags adds no information: its smoothed state is what the trajectory of the other
// frames says at its time.
TEST_P(TrajectoryTest, BetweenStatesItEqualsAStateWithoutMeasurements) {
  ExactModelOptions model = Model();
  model.frames = 12;
  model.rate_hz = 10;
  model.linear.psd = model.angular.psd = 0.5;
  model.seed = 3;
  const ExactModelFlight flight = DrawFlight(model);
  const auto plain = RunBatch(SetupFor(model), flight.measurements);
  ASSERT_TRUE(plain) << plain.error().message;

  for (const int64_t offset_ns : {10'000'000, 50'000'000, 93'000'000}) {
    std::vector<FrameMeasurements> more = flight.measurements;
    FrameMeasurements extra;
    extra.t_ns = more[5].t_ns + offset_ns;
    more.insert(more.begin() + 6, extra);
    const auto dense = RunBatch(SetupFor(model), more);
    ASSERT_TRUE(dense) << dense.error().message;
    const auto asked = plain->trajectory.At(extra.t_ns);
    ASSERT_TRUE(asked);
    EXPECT_EQ(dense->frames[6].status, FrameStatus::kPredicted);
    // Exact but for terms of second order in the rotation between the states.
    const StateVector d = Difference(asked->state, dense->frames[6].state);
    EXPECT_LT(d.dot(dense->frames[6].covariance.llt().solve(d)), 1e-4) << offset_ns;
    EXPECT_LT((asked->covariance - dense->frames[6].covariance).norm(),
              1e-2 * dense->frames[6].covariance.norm())
        << offset_ns;
  }
}

TEST_P(TrajectoryTest, AtAStateItIsThatState) {
  ExactModelOptions model = Model();
  model.frames = 6;
  const ExactModelFlight flight = DrawFlight(model);
  const auto result = RunBatch(SetupFor(model), flight.measurements);
  ASSERT_TRUE(result);
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    const auto asked = result->trajectory.At(flight.measurements[i].t_ns);
    ASSERT_TRUE(asked);
    EXPECT_LT(Difference(asked->state, result->frames[i].state).norm(), 1e-9);
    EXPECT_LT((asked->covariance - result->frames[i].covariance).norm(), 1e-9);
  }
}

TEST_P(TrajectoryTest, BeyondItsEndsThePriorCarriesItOn) {
  ExactModelOptions model = Model();
  model.frames = 8;
  model.rate_hz = 10;
  const ExactModelFlight flight = DrawFlight(model);
  std::vector<FrameMeasurements> more = flight.measurements;
  FrameMeasurements late;
  late.t_ns = more.back().t_ns + 300'000'000;
  more.push_back(late);
  const auto result = RunBatch(SetupFor(model), flight.measurements);
  const auto dense = RunBatch(SetupFor(model), more);
  ASSERT_TRUE(result);
  ASSERT_TRUE(dense);
  const auto after = result->trajectory.At(late.t_ns);
  const StateVector d = Difference(after->state, dense->frames.back().state);
  EXPECT_LT(d.norm(), 1e-6);
  EXPECT_LT((after->covariance - dense->frames.back().covariance).norm(),
            1e-2 * dense->frames.back().covariance.norm());
  const auto before = result->trajectory.At(flight.measurements.front().t_ns - 300'000'000);
  EXPECT_GT(before->covariance.trace(), result->frames.front().covariance.trace());
  EXPECT_GT(before->covariance.llt().info(), -1);
  EXPECT_FALSE(Trajectory{}.At(0));
}

}  // namespace
}  // namespace tagtwist
