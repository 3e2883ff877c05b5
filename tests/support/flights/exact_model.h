#pragma once
#include <gtest/gtest.h>

#include <cstdint>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// A flight over the course's mat drawn from the estimator's own model: states from its motion
/// prior, corners with Gaussian noise. What an estimator says of its errors must then hold.
struct ExactModelOptions {
  int frames = 60;
  double rate_hz = 50;
  MotionPrior linear{WhiteNoiseOn::kJerk, 0.5}, angular{WhiteNoiseOn::kJerk, 0.5};
  double corner_sigma_px = 0.15;
  int max_tags = 6;  // the first ones in view, by id
  unsigned random_seed = 1;
};

struct ExactModelFlight {
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
};

ExactModelFlight DrawFlight(const ExactModelOptions& options);
/// Over another map, by another camera, about that pose. Nothing hides a tag.
ExactModelFlight DrawFlight(const ExactModelOptions& options, const EstimatorSetup& setup,
                            const Pose& world_from_body);

/// The model under that prior, with densities to suit the mat.
ExactModelOptions ModelUnder(WhiteNoiseOn prior, unsigned seed = 1);

/// Tests that hold under both priors: INSTANTIATE_UNDER_BOTH_PRIORS(suite).
class UnderBothPriors : public testing::TestWithParam<WhiteNoiseOn> {
 protected:
  static ExactModelOptions Model(unsigned seed = 1) { return ModelUnder(GetParam(), seed); }
};
#define INSTANTIATE_UNDER_BOTH_PRIORS(suite) \
  INSTANTIATE_TEST_SUITE_P(                  \
      Priors, suite, testing::Values(WhiteNoiseOn::kAcceleration, WhiteNoiseOn::kJerk), PriorName)

/// For the names of tests: "Acceleration" or "Jerk".
std::string PriorName(const testing::TestParamInfo<WhiteNoiseOn>& prior);

/// The noise that the flight was drawn with.
EstimatorOptions GivenNoise(const ExactModelOptions& model);

/// The course's camera, mount and mat; and what the solvers take of them.
SetUp CourseSetUp();
EstimatorSetup CourseSetup(const EstimatorOptions& options = {});
/// The set-up that a solver's setup was made of.
SetUp SetUpOf(const EstimatorSetup& setup);

}  // namespace tagtwist::internal
