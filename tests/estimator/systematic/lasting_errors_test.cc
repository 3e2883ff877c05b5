// What a window learns of errors that last, and when.
#include "estimator/systematic/lasting_errors.h"

#include <gtest/gtest.h>

#include <vector>

#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/simulated_flight.h"

namespace tagtwist::internal::lasting_errors_test {
namespace {

// The course's map, every other tag off by so much along x.
EstimatorSetup SetupOff(double off_m, const EstimatorOptions& options = {}) {
  SetUp set_up = CourseSetUp();
  std::vector<Tag> tags = set_up.map.tags();
  for (Tag& tag : tags) tag.world_from_tag.params(4) += tag.id % 2 == 0 ? off_m : 0;
  set_up.map = TagMap(set_up.map.family(), tags);
  return MakeEstimatorSetup(set_up, options);
}

// The counts of frames of a flight after which what is known has changed.
std::vector<size_t> ChangesOf(LastingErrors* errors) {
  const SimulatedFlight flight = SimulateCorners("figure8", 12, 49);
  NoiseModel noise;
  noise.corner_sigma_px = 0.15;
  std::vector<size_t> out;
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    const FrameMeasurements& frame = flight.measurements[i];
    if (errors->Add(noise, frame.t_ns, flight.truth[i], frame.tags)) out.push_back(i + 1);
  }
  return out;
}

TEST(LastingErrors, AreLearnedAnewWhenTwiceAsManyFramesHavePassed) {
  LastingErrors errors(SetupOff(0.004));
  EXPECT_FALSE(errors.AreAny());
  const std::vector<size_t> changes = ChangesOf(&errors);
  EXPECT_TRUE(errors.AreAny());
  ASSERT_GE(changes.size(), 4U);
  for (size_t i = 0; i + 1 < changes.size(); ++i) {
    EXPECT_NEAR(static_cast<double>(changes[i + 1]), 2.0 * static_cast<double>(changes[i]), 2.0);
  }
  EXPECT_GT(changes.back(), 500U);  // of 588 frames; one of four is kept
  const Eigen::MatrixXd root =
      errors.TimesRoot(Eigen::MatrixXd::Identity(errors.basis().size(), errors.basis().size()));
  EXPECT_GT(root.norm(), 0.004);
}

TEST(LastingErrors, ThatAreNotThereAreNotLearned) {
  LastingErrors errors(SetupOff(0));
  EXPECT_TRUE(ChangesOf(&errors).empty());
  EXPECT_FALSE(errors.AreAny());
}

TEST(LastingErrors, WhatIsGivenCountsFromTheStart) {
  EstimatorOptions given;
  given.tag_sigma_m = 0.002;
  const LastingErrors errors(SetupOff(0, given));
  EXPECT_TRUE(errors.AreAny());
  EXPECT_GT(errors.TimesRoot(Eigen::MatrixXd::Ones(1, errors.basis().size())).norm(), 0.002);
}

}  // namespace
}  // namespace tagtwist::internal::lasting_errors_test
