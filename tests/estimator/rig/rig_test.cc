#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/linear_system.h"
#include "estimator/rig/rig_pose.h"
#include "frontend/types/nees.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/rig_flights.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::rig_test {
namespace {

// Which cameras take frame i.
using Schedule = std::vector<int> (*)(int i);
std::vector<int> AllAtOnce(int) { return {0, 1, 2}; }
std::vector<int> InTurn(int i) { return {i % 3}; }
std::vector<int> TheFirst(int) { return {0}; }

ExactModelFlight Fly(const ExactModelOptions& model, Schedule schedule) {
  const tagtwist::SetUp set_up = RigOfThree();
  ExactModelFlight out = DrawFlight(model);
  for (size_t i = 0; i < out.truth.size(); ++i) {
    out.measurements[i].tags.clear();
    for (const int camera : schedule(static_cast<int>(i))) {
      const auto seed =
          static_cast<unsigned>(1000 * model.random_seed + 3 * i) + static_cast<unsigned>(camera);
      for (const TagDetection& tag : SeenByCamera(set_up, camera, out.truth[i].world_from_body,
                                                  model.corner_sigma_px, seed)) {
        out.measurements[i].tags.push_back(tag);
      }
    }
  }
  return out;
}

void ExpectHonest(Schedule schedule) {
  ExpectHonestEstimates(RigOfThree(),
                        [&](const ExactModelOptions& model) { return Fly(model, schedule); });
}

TEST(Rig, SlowCovariancesHoldOfCamerasThatSeeAtOnce) { ExpectHonest(AllAtOnce); }

TEST(Rig, SlowCovariancesHoldOfCamerasThatSeeInTurn) { ExpectHonest(InTurn); }

TEST(Rig, MoreCamerasKnowMore) {
  const ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk);
  const auto sigma = [&](Schedule schedule) {
    const auto run = RunBatch(RigOfThree(), GivenNoise(model), Fly(model, schedule).measurements);
    EXPECT_TRUE(run) << run.error().message;
    return run ? std::sqrt(run->frames[30].covariance.diagonal().segment<3>(3).sum()) : 0;
  };
  EXPECT_LT(sigma(AllAtOnce), 0.8 * sigma(TheFirst));
}

TEST(Rig, EachCameraIsAccountedFor) {
  const ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk);
  const ExactModelFlight flight = Fly(model, InTurn);
  const auto run = RunBatch(RigOfThree(), GivenNoise(model), flight.measurements);
  ASSERT_TRUE(run) << run.error().message;
  ASSERT_EQ(run->cameras.size(), 3U);
  for (size_t i = 0; i < 3; ++i) {
    size_t frames = 0, tags = 0;
    for (size_t k = i; k < flight.measurements.size(); k += 3) {
      frames += flight.measurements[k].tags.empty() ? 0 : 1;
      tags += flight.measurements[k].tags.size();
    }
    EXPECT_EQ(run->cameras[i].name, "cam" + std::to_string(i));
    EXPECT_EQ(run->cameras[i].frames, frames);
    EXPECT_EQ(run->cameras[i].tags, tags);
    EXPECT_NEAR(run->cameras[i].rms_px, model.corner_sigma_px, 0.05);
  }
}

TEST(Rig, OneCameraHasNoAccountOfItsOwn) {
  const ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk);
  const auto run = RunBatch(CourseSetUp(), GivenNoise(model), DrawFlight(model).measurements);
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_TRUE(run->cameras.empty());
}

// A mount that is off by 3 mm and 3 mrad is in no camera's noise; the covariance has it.
TEST(Rig, AMountThatIsOffIsInTheCovariance) {
  ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk);
  model.frames = 150;
  const ExactModelFlight flight = Fly(model, AllAtOnce);
  tagtwist::SetUp off = RigOfThree();
  for (size_t i = 1; i < 3; ++i) {
    off.rig.cameras[i].cam_from_body =
        off.rig.cameras[i].cam_from_body * MakePose(ExpSo3({0.003, -0.003, 0}), {0.003, 0, 0.003});
  }
  EstimatorOptions options = GivenNoise(model);
  options.corner_sigma_px.reset();
  const auto run = RunBatch(off, options, flight.measurements);
  ASSERT_TRUE(run) << run.error().message;
  EXPECT_GT(run->systematic.mount_sigma_rad + run->systematic.mount_sigma_m, 5e-4);
  double nees = 0;
  for (size_t i = 0; i < flight.truth.size(); ++i) {
    const FrameEstimate& frame = run->frames[i];
    const auto of_frame = Nees(flight.truth[i], frame.state, frame.covariance, kWholeState);
    ASSERT_TRUE(of_frame);
    nees += *of_frame;
  }
  EXPECT_LT(nees / static_cast<double>(flight.truth.size()), 3 * 12);
}

// Points of the floor that the second camera follows, with a frame of another camera between: of
// the body's true poses they are where it sees them.
TEST(Rig, TracksAreSeenThroughTheirCamerasMount) {
  const EstimatorSetup setup = MakeEstimatorSetup(RigOfThree(), {});
  GraphInput input;
  for (int i = 0; i < 3; ++i) {
    GraphFrame frame;
    frame.t_ns = 20'000'000 * i;
    frame.state.world_from_body = Hover({1.2 + 0.05 * i, 1.1, 1.3}, 0.1 * i, {0.03, 0.02 * i, 0});
    input.frames.push_back(frame);
  }
  const MountedCamera second = setup.CameraOf(1);
  for (const double x_m : {1.1, 1.3}) {
    TrackSegment segment;
    segment.camera = 1;
    for (const int i : {0, 2}) {
      const Pose& body = input.frames[static_cast<size_t>(i)].state.world_from_body;
      Eigen::Vector2d pixel;
      ASSERT_TRUE(
          second.camera.Project(second.CamFromMap(body) * Eigen::Vector3d(x_m, 1.2, 0), &pixel));
      segment.AddView(i, pixel);
    }
    input.segments.push_back(segment);
  }
  const Graph graph = BuildGraph(setup, NoiseModel(), input);
  ASSERT_EQ(graph.points.size(), 2u);
  EXPECT_NEAR(graph.points[0].x(), 1.1, 1e-9);
  std::vector<int> states;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTrack) continue;
    LinearFactor linear;
    ASSERT_TRUE(LinearizeFactor(graph, factor, &linear));
    EXPECT_LT(linear.residual.norm(), 1e-6);
    states.push_back(factor.blocks.front().index);
  }
  EXPECT_EQ(states, (std::vector<int>{0, 2, 0, 2}));
}

TEST(RigPose, IsThatOfAllCamerasTags) {
  const tagtwist::SetUp set_up = RigOfThree();
  const EstimatorSetup setup = MakeEstimatorSetup(set_up, {});
  const Pose truth = Hover({1.6, 1.3, 1.3}, 0.4, {0.05, -0.1, 0});
  std::vector<TagDetection> tags;
  for (const int camera : {0, 1, 2}) {
    const auto own = SeenByCamera(set_up, camera, truth, 0, 1);
    tags.insert(tags.end(), own.begin(), own.end());
  }
  ASSERT_GT(tags.size(), 4U);
  const FramePose found = FindPoseOfTags(setup, tags);
  ASSERT_EQ(found.status, FramePoseStatus::kOk);
  EXPECT_LT(PositionErrorM(found.world_from_body, truth), 1e-6);
  EXPECT_LT(RotationErrorRad(found.world_from_body, truth), 1e-6);
  EXPECT_THAT(found.tag_inlier, testing::Each(true));
  tags.back().id = tags.back().id == 0 ? 1 : tags.back().id - 1;  // one is another's
  const FramePose with_wrong = FindPoseOfTags(setup, tags);
  EXPECT_LT(PositionErrorM(with_wrong.world_from_body, truth), 1e-6);
  EXPECT_FALSE(with_wrong.tag_inlier.back());
  EXPECT_EQ(FindPoseOfTags(setup, {}).status, FramePoseStatus::kNoTags);
}

TEST(RigPose, ATagOfACameraThatTheRigLacksIsABrokenPromise) {
  TagDetection tag{};
  tag.id = 0;
  tag.camera = 1;
  EXPECT_THROW(FindPoseOfTags(CourseSetup(), {tag}), std::logic_error);
}

}  // namespace
}  // namespace tagtwist::internal::rig_test
