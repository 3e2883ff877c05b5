#include "frontend/tags/tag_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <opencv2/imgproc.hpp>

#include "estimator/online/guidance.h"
#include "frontend/front_end.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/flight_scene.h"

namespace tagtwist::internal::tag_follower_test {
namespace {

constexpr double kIntervalS = 0.02;

struct Step {
  FrameEstimate estimate;
  BodyState truth;
};

std::vector<SimulatedFrame> Render(const std::string& name, double from_s, int frames) {
  SimulatorOptions options;
  options.exposure_s = 0;
  options.renderer.supersampling = 2;
  const RenderedFlight flight = MakeRenderedFlight(name, MakeTagMap({}), options);
  std::vector<SimulatedFrame> out;
  for (int i = 0; i < frames; ++i) {
    out.push_back(flight.simulator.MakeFrame(static_cast<uint64_t>(i),
                                             flight.StampAt(from_s + kIntervalS * i)));
  }
  return out;
}

const std::vector<SimulatedFrame>& Agile() {
  static const std::vector<SimulatedFrame> frames = Render("agile", 2, 70);
  return frames;
}

// A clock whose time is up when it has been asked so often.
TimeUp UpAfter(int asks) {
  return [left = asks]() mutable { return left-- <= 0; };
}

// The frames through detection and window, guided or not. With a number, detection's time and the
// window's are each up after so many asks.
std::vector<Step> Follow(const std::vector<SimulatedFrame>& frames, bool guided,
                         const std::optional<int>& asks = {}) {
  const EstimatorSetup setup = CourseSetup();
  auto follower = TagFollower::Create(SetUpOf(setup), {});
  EXPECT_TRUE(follower);
  FrontEnd front_end(SetUpOf(setup), {});
  SlidingWindow window(SetUpOf(setup), setup.options);
  std::vector<Step> out;
  for (const SimulatedFrame& frame : frames) {
    const auto prediction = guided ? PredictPose(window, frame.t_ns) : std::nullopt;
    const auto tags = follower->Find(frame.image, prediction, asks ? UpAfter(*asks) : TimeUp());
    FrameMeasurements measurement = front_end.Process(frame.t_ns, tags, frame.image);
    measurement.cut_short = follower->was_cut_short();
    const auto added = window.Add(measurement, asks ? UpAfter(*asks) : TimeUp());
    EXPECT_TRUE(added) << added.error().message;
    out.push_back({added->current, frame.truth});
  }
  return out;
}

Eigen::Vector2d PositionAndVelocityRmse(const std::vector<Step>& steps, size_t first) {
  Eigen::Vector2d sum(0, 0);
  for (size_t i = first; i < steps.size(); ++i) {
    const StateVector e = Difference(steps[i].estimate.state, steps[i].truth);
    sum += Eigen::Vector2d(e.segment<3>(3).squaredNorm(), e.segment<3>(6).squaredNorm());
  }
  return (sum / static_cast<double>(steps.size() - first)).cwiseSqrt();
}

TEST(TagFollower, SlowAsAccurateAsSearchingEveryImage) {
  const auto guided = Follow(Agile(), true), full = Follow(Agile(), false);
  const Eigen::Vector2d ratio =
      PositionAndVelocityRmse(guided, 20).cwiseQuotient(PositionAndVelocityRmse(full, 20));
  EXPECT_LT(ratio.x(), 1.1) << "position";
  EXPECT_LT(ratio.y(), 1.1) << "velocity";
  int guided_tags = 0, full_tags = 0;
  for (size_t i = 0; i < full.size(); ++i) {
    guided_tags += guided[i].estimate.n_tags;
    full_tags += full[i].estimate.n_tags;
  }
  EXPECT_GE(guided_tags, full_tags * 0.97);
}

TEST(TagFollower, TheSameTwice) {
  const std::vector<SimulatedFrame> frames(Agile().begin(), Agile().begin() + 20);
  const auto first = Follow(frames, true), second = Follow(frames, true);
  for (size_t i = 0; i < first.size(); ++i) {
    EXPECT_EQ(first[i].estimate.state.world_from_body.params,
              second[i].estimate.state.world_from_body.params);
    EXPECT_EQ(first[i].estimate.covariance, second[i].estimate.covariance);
  }
}

// A camera shaken until no frame shows a tag, then still.
TEST(TagFollower, LostFramesAreMarkedAndTrackingIsBackWithinThree) {
  constexpr size_t kFrom = 30, kTo = 45;
  std::vector<SimulatedFrame> frames = Agile();
  for (size_t i = kFrom; i < kTo; ++i) {
    const int k = static_cast<int>(i);
    cv::Mat blurred;
    cv::blur(frames[i].image, blurred, {1 + 8 * (3 + k % 3), 1 + 8 * (3 + k % 2)});
    frames[i].image = blurred;
  }
  const auto steps = Follow(frames, true);
  for (size_t i = kFrom; i < kTo; ++i) {
    EXPECT_EQ(steps[i].estimate.status, FrameStatus::kPredicted) << i;
  }
  for (size_t i = kTo + 2; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].estimate.status, FrameStatus::kOk) << i;
    const StateVector e = Difference(steps[i].estimate.state, steps[i].truth);
    EXPECT_LT(e.segment<3>(3).norm(), 0.003) << i;
  }
}

// From one frame to the next the camera is elsewhere over the mat.
TEST(TagFollower, AKidnappedCameraFindsItsWay) {
  std::vector<SimulatedFrame> frames(Agile().begin(), Agile().begin() + 25);
  for (SimulatedFrame& frame : Render("circle", 12, 15)) {
    frame.t_ns = frames.back().t_ns + static_cast<int64_t>(1e9 * kIntervalS);
    frames.push_back(std::move(frame));
  }
  const auto steps = Follow(frames, true);
  for (size_t i = 28; i < steps.size(); ++i) {
    EXPECT_EQ(steps[i].estimate.status, FrameStatus::kOk) << i;
  }
  const StateVector e = Difference(steps.back().estimate.state, steps.back().truth);
  EXPECT_LT(e.segment<3>(3).norm(), 0.01);
}

// The worst of clocks: one part of an image is searched, one iteration made.
TEST(TagFollower, EveryFrameHasAnAnswerWhereTheTimeIsAlwaysUp) {
  const auto steps = Follow(Agile(), true, 0);
  ASSERT_EQ(steps.size(), Agile().size());
  for (size_t i = 20; i < steps.size(); ++i) {
    const FrameEstimate& estimate = steps[i].estimate;
    EXPECT_EQ(estimate.status,
              estimate.n_tags > 0 ? FrameStatus::kHurried : FrameStatus::kPredicted)
        << i;
    const StateVector e = Difference(estimate.state, steps[i].truth);
    EXPECT_LT(e.segment<3>(3).norm(), 0.1) << i;
  }
}

TEST(TagFollower, AsManyTagsAsThereIsTimeFor) {
  const auto steps = Follow(Agile(), true, 4);
  int hurried = 0;
  for (size_t i = 25; i < steps.size(); ++i) {
    const FrameEstimate& estimate = steps[i].estimate;
    EXPECT_GE(estimate.n_tags, 1) << i;
    EXPECT_LE(estimate.n_tags, 4) << i;
    hurried += estimate.status == FrameStatus::kHurried ? 1 : 0;
    const StateVector e = Difference(estimate.state, steps[i].truth);
    EXPECT_LT(e.segment<3>(3).norm(), 0.003) << i;
  }
  EXPECT_GT(hurried, 30);
}

TEST(TagFollower, SlowATimeThatSufficesChangesNothing) {
  const auto in_time = Follow(Agile(), true, 1000000), unbounded = Follow(Agile(), true);
  const Eigen::Vector2d ratio =
      PositionAndVelocityRmse(in_time, 20).cwiseQuotient(PositionAndVelocityRmse(unbounded, 20));
  EXPECT_NEAR(ratio.x(), 1, 0.1);
  EXPECT_NEAR(ratio.y(), 1, 0.1);
  for (const Step& step : in_time) EXPECT_NE(step.estimate.status, FrameStatus::kHurried);
}

}  // namespace
}  // namespace tagtwist::internal::tag_follower_test
