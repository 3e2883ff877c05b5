// Frames in, states out: what a program of one's own sees.
#include "estimator/online/online_estimator.h"

#include <gtest/gtest.h>

#include "estimator/online/guidance.h"
#include "frontend/types/nees.h"
#include "tests/support/flights/flight_scene.h"

namespace tagtwist::internal::online_estimator_test {
namespace {

constexpr int kFrames = 12;

RenderedFlight Flight(bool images) {
  SimulatorOptions options;
  options.images = images;
  return MakeRenderedFlight("figure8", MakeTagMap(TagGrid()), options);
}

double ErrorM(const FrameEstimate& estimate, const SimulatedFrame& frame) {
  return (estimate.state.world_from_body.translation() - frame.truth.world_from_body.translation())
      .norm();
}

TEST(OnlineEstimator, ImagesBecomeStates) {
  const RenderedFlight flight = Flight(true);
  auto estimator = OnlineEstimator::Create(DefaultConfig());
  ASSERT_TRUE(estimator);
  size_t n_lagged = 0;
  for (int i = 0; i < kFrames; ++i) {
    const SimulatedFrame frame = flight.simulator.MakeFrame(i, flight.StampAt(0.02 * i));
    const auto output = estimator->AddImage(frame.t_ns, frame.image);
    ASSERT_TRUE(output);
    EXPECT_EQ(output->current.t_ns, frame.t_ns);
    EXPECT_GE(output->current.n_tags, 8);
    EXPECT_LT(ErrorM(output->current, frame), 1e-3);
    n_lagged += output->lagged.size();
  }
  EXPECT_TRUE(PredictPose(estimator->window(), flight.StampAt(0.02 * kFrames)));
  EXPECT_EQ(n_lagged + estimator->Finish().size(), kFrames);
}

TEST(OnlineEstimator, DetectionsAreFilteredAndImagesBesideThemGiveTracks) {
  const RenderedFlight flight = Flight(true);
  Config config = DefaultConfig();
  config.front_end.detector.refine_pattern = false;  // tracks whatever the number of tags
  auto estimator = OnlineEstimator::Create(config);
  ASSERT_TRUE(estimator);
  for (int i = 0; i < 4; ++i) {
    SimulatedFrame frame = flight.simulator.MakeFrame(i, flight.StampAt(0.02 * i));
    const size_t n_tags = frame.detections.size();
    TagDetection stranger = frame.detections.front();
    stranger.id = 500;
    frame.detections.push_back(stranger);
    const auto output =
        estimator->AddTags(frame.t_ns, frame.detections, i == 3 ? cv::Mat() : frame.image);
    ASSERT_TRUE(output);
    EXPECT_EQ(output->current.n_tags, n_tags);
    EXPECT_EQ(output->current.n_tracks > 0, i < 3) << i;
    EXPECT_LT(ErrorM(output->current, frame), 5e-3);
  }
}

// No tag is told any more, and images come so rarely that points move 50 to 200 px between them:
// what tracks then tell is right, or they are given up. Over some starts in a lively flight.
TEST(OnlineEstimator, TracksThatAreLostTellNothing) {
  SimulatorOptions options;
  options.exposure_s = 0;
  options.renderer.supersampling = 2;
  const RenderedFlight seen = MakeRenderedFlight("agile", MakeTagMap(TagGrid()), options);
  options.images = false;
  const RenderedFlight told = MakeRenderedFlight("agile", MakeTagMap(TagGrid()), options);
  double sum = 0;
  int n_frames = 0, n_beyond = 0;
  for (const double start_s : {1.0, 2.5, 4.0, 5.5}) {
    auto estimator = OnlineEstimator::Create(DefaultConfig());
    ASSERT_TRUE(estimator);
    for (int i = 0; i < 22; ++i) {
      const double t_s = start_s + (i < 16 ? 0.02 * i : 0.3 + 0.08 * (i - 15));
      const SimulatedFrame frame = (i < 15 ? told : seen).simulator.MakeFrame(i, told.StampAt(t_s));
      const auto output = estimator->AddTags(
          frame.t_ns, i < 16 ? frame.detections : std::vector<TagDetection>(), frame.image);
      ASSERT_TRUE(output);
      if (i < 16 || output->current.status == FrameStatus::kNoFix) continue;
      const auto nees =
          Nees(frame.truth, output->current.state, output->current.covariance, kPoseEntries);
      ASSERT_TRUE(nees);
      sum += *nees / 6;
      ++n_frames;
      n_beyond += *nees / 6 > 5 ? 1 : 0;
    }
  }
  EXPECT_EQ(n_frames, 24);
  EXPECT_LT(sum / n_frames, 2);
  EXPECT_EQ(n_beyond, 0);
}

// A clock whose time is always up, and the stages as they are told.
TEST(OnlineEstimator, StopsWhenTheTimeIsUpAndTellsItsStages) {
  const RenderedFlight flight = Flight(true);
  bool is_up = false;
  std::vector<FrameStage> stages;
  OnlineOptions options;
  options.detection_time_up = options.solve_time_up = [&] { return is_up; };
  options.after_stage = [&](FrameStage stage) { stages.push_back(stage); };
  auto estimator = OnlineEstimator::Create(DefaultConfig(), options);
  ASSERT_TRUE(estimator);
  for (int i = 0; i < kFrames; ++i) {
    is_up = i + 1 == kFrames;
    stages.clear();
    const SimulatedFrame frame = flight.simulator.MakeFrame(i, flight.StampAt(0.02 * i));
    const auto output = estimator->AddImage(frame.t_ns, frame.image);
    ASSERT_TRUE(output);
    EXPECT_EQ(output->current.status == FrameStatus::kOk, !is_up) << i;
    EXPECT_EQ(estimator->measurements().cut_short, is_up);
    EXPECT_EQ(stages, (std::vector<FrameStage>{FrameStage::kDetect, FrameStage::kTrack,
                                               FrameStage::kClosedForm, FrameStage::kSolve}));
  }
}

TEST(OnlineEstimator, MeasurementsOfElsewhereGiveTheSameStates) {
  const RenderedFlight flight = Flight(true);
  OnlineOptions options;
  options.detection = DetectionMode::kFull;
  auto from_images = OnlineEstimator::Create(DefaultConfig(), options),
       from_measurements = OnlineEstimator::Create(DefaultConfig(), options);
  ASSERT_TRUE(from_images && from_measurements);
  EXPECT_FALSE(from_images->is_guided());
  for (int i = 0; i < kFrames; ++i) {
    const SimulatedFrame frame = flight.simulator.MakeFrame(i, flight.StampAt(0.02 * i));
    const auto a = from_images->AddImage(frame.t_ns, frame.image);
    const auto b = from_measurements->AddMeasurements(from_images->measurements());
    ASSERT_TRUE(a && b);
    EXPECT_EQ(a->current.covariance, b->current.covariance);
  }
  EXPECT_FALSE(from_measurements->AddMeasurements(from_images->measurements())) << "the same stamp";
}

TEST(OnlineEstimator, RefusesWhatCannotBeAndGoesOn) {
  const RenderedFlight flight = Flight(false);
  Config config = DefaultConfig();
  auto estimator = OnlineEstimator::Create(config);
  ASSERT_TRUE(estimator);
  const cv::Mat small(100, 100, CV_8U, cv::Scalar(0));
  const auto refused = estimator->AddImage(5, small);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().message, "the image has 100 x 100 px, the configured camera 376 x 240");
  const SimulatedFrame frame = flight.simulator.MakeFrame(0, flight.StampAt(0.1));
  ASSERT_TRUE(estimator->AddTags(frame.t_ns, frame.detections));
  const auto late = estimator->AddTags(frame.t_ns, frame.detections);
  ASSERT_FALSE(late);
  const std::string stamp = std::to_string(frame.t_ns);
  EXPECT_EQ(late.error().message, "stamps must grow: " + stamp + " ns follows " + stamp + " ns");
  EXPECT_TRUE(estimator->AddTags(frame.t_ns + 20'000'000, frame.detections));

  config.set_up.map = TagMap("tag99h99", config.set_up.map.tags());
  EXPECT_FALSE(OnlineEstimator::Create(config));
}

}  // namespace
}  // namespace tagtwist::internal::online_estimator_test
