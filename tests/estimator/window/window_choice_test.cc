// What the window does where a frame's tags do not settle the pose: two minima, nonsense, another
// place, none at all.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "estimator/start/pose_path.h"
#include "frontend/geometry/frame_pose.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/flights/window_run.h"

namespace tagtwist::internal::window_choice_test {
namespace {

constexpr double kRateHz = 50;
int64_t StampOf(size_t frame) { return static_cast<int64_t>(frame) * 20000000; }

struct Flight {
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
};

Flight Fly(const TagMap& map, size_t frames, double noise_px, unsigned seed,
           const std::function<Pose(double)>& world_from_body) {
  const EstimatorSetup setup = CourseSetup();
  Flight flight;
  for (size_t i = 0; i < frames; ++i) {
    BodyState state;
    state.world_from_body = world_from_body(static_cast<double>(i) / kRateHz);
    FrameMeasurements m;
    m.t_ns = StampOf(i);
    m.tags = SeeTags(map, setup.camera, setup.cam_from_body * Inverse(state.world_from_body),
                     noise_px, 1000 * seed + static_cast<unsigned>(i));
    flight.truth.push_back(state);
    flight.measurements.push_back(std::move(m));
  }
  return flight;
}

// Each frame once, in order.
void ExpectAllFrames(const std::vector<FrameEstimate>& frames, size_t size) {
  ASSERT_EQ(frames.size(), size);
  for (size_t i = 0; i < size; ++i) EXPECT_EQ(frames[i].t_ns, StampOf(i));
}

TagMap OneTag() { return TagMap("tag36h11", {*CourseSetup().map.Find(54)}); }

// Over the tag, tilted so that the mirrored pose lies 12 degrees off.
Pose Tilted(double height_m) {
  const Eigen::Vector3d over = CourseSetup().map.Find(54)->world_from_tag.translation();
  return Hover(over + Eigen::Vector3d(0.02, -0.13, height_m), 0.2, {0.105, 0, 0});
}

TEST(WindowChoice, AWrongMinimumIsNeverTold) {
  constexpr double kHeightM = 1.6, kNoisePx = 0.15;
  const EstimatorSetup setup = CourseSetup();
  int misled = 0, told = 0;
  for (unsigned seed = 1; seed <= 60 && misled < 3; ++seed) {
    const Flight flight =
        Fly(OneTag(), 60, kNoisePx, seed, [](double) { return Tilted(kHeightM); });
    const Pose& truth = flight.truth.front().world_from_body;
    const FramePose first = FindFramePose(flight.measurements.front().tags, setup.map, setup.camera,
                                          setup.cam_from_body);
    if (RotationErrorRad(first.world_from_body, truth) < 0.15) continue;  // this noise is harmless
    ++misled;
    const WindowRun run = RunWindow(CourseSetup(), flight.measurements);
    ExpectAllFrames(run.lagged, 60);
    for (const auto* frames : {&run.current, &run.lagged}) {
      for (const FrameEstimate& frame : *frames) {
        if (frame.status == FrameStatus::kNoFix) continue;
        ++told;
        EXPECT_LT(RotationErrorRad(frame.state.world_from_body, truth), 0.16)
            << "seed " << seed << " at " << frame.t_ns;
      }
    }
    EXPECT_EQ(run.current.back().status, FrameStatus::kOk);
  }
  EXPECT_EQ(misled, 3);
  EXPECT_GT(told, 200);
}

TEST(WindowChoice, TheLikeliestPathIsNotLedAstrayByItsFirstFrame) {
  const EstimatorSetup setup = CourseSetup();
  const Flight flight = Fly(OneTag(), 40, 0.15, 2, [](double) { return Tilted(1.2); });
  const Pose& right = flight.truth.front().world_from_body;
  std::vector<PoseChoice> choices;
  for (const FrameMeasurements& m : flight.measurements) {
    const auto mirrored = MirroredPose(m.tags, setup.map, setup.cam_from_body, right);
    ASSERT_TRUE(mirrored);
    EXPECT_GT(RotationErrorRad(*mirrored, right), 0.15);
    choices.push_back({m.t_ns, m.tags, {*mirrored, right}});
  }
  choices[0].poses.pop_back();  // there nothing but the wrong one is on offer
  choices[7] = {StampOf(7), {}, {}};
  const auto path = LikeliestPath(setup, choices);
  ASSERT_EQ(path.size(), choices.size());
  EXPECT_TRUE(path[0]);
  for (size_t i = 1; i < path.size(); ++i) {
    ASSERT_EQ(path[i].has_value(), i != 7);
    if (i != 7) {
      EXPECT_EQ(path[i]->params, right.params) << i;
    }
  }
}

Pose Circle(double t) {
  const double angle = 1.2 * t;
  return Hover({1.7 + 0.5 * std::cos(angle), 1.4 + 0.5 * std::sin(angle), 1.2}, 0.3,
               {0.1 * std::sin(angle), 0.1 * std::cos(angle), 0});
}

// One tag alone with the name of another, whose pose nothing confirms.
TEST(WindowChoice, AFrameOfNonsenseDoesNotMoveTheState) {
  Flight flight = Fly(CourseSetup().map, 100, 0.1, 1, Circle);
  flight.measurements[70].tags.resize(1);
  flight.measurements[70].tags[0].id = 3;
  const WindowRun run = RunWindow(CourseSetup(), flight.measurements);
  ExpectAllFrames(run.lagged, 100);
  EXPECT_EQ(run.current[70].status, FrameStatus::kPredicted);
  EXPECT_EQ(run.current[70].n_tags, 0);
  for (size_t i = 20; i < 100; ++i) {
    EXPECT_LT(PositionErrorM(run.current[i].state.world_from_body, flight.truth[i].world_from_body),
              0.004)
        << i;
  }
}

// The mat seen from elsewhere in one frame, by tags that agree: that is where the camera was.
TEST(WindowChoice, TagsThatAgreeAreBelievedForAFrameAndLeaveNothingBehind) {
  const TagMap map = CourseSetup().map;
  Flight flight = Fly(map, 100, 0.1, 1, Circle);
  const Flight other = Fly(map, 1, 0.1, 9, [](double) { return Hover({0.8, 2.2, 0.9}, 1.5); });
  flight.measurements[40].tags = other.measurements[0].tags;
  flight.truth[40] = other.truth[0];
  const WindowRun run = RunWindow(CourseSetup(), flight.measurements);
  ExpectAllFrames(run.lagged, 100);
  for (const auto* frames : {&run.current, &run.lagged}) {
    for (size_t i = 20; i < 100; ++i) {
      EXPECT_EQ((*frames)[i].status, FrameStatus::kOk) << i;
      EXPECT_LT(PositionErrorM((*frames)[i].state.world_from_body, flight.truth[i].world_from_body),
                0.004)
          << i;
    }
  }
}

// From 60 on the body is elsewhere, where it sees all tags or one alone.
Flight CarriedElsewhere(bool sees_one) {
  Flight out = Fly(CourseSetup().map, 120, 0.1, 1, [](double t) {
    Pose pose = Circle(t);
    if (t > 1.19) pose.params.segment<3>(4) += Eigen::Vector3d(0.6, -0.5, 0.4);
    return pose;
  });
  for (size_t i = 60; sees_one && i < 63; ++i) out.measurements[i].tags.resize(1);
  return out;
}

TEST(WindowChoice, AnotherPlaceIsTakenAtOnceWhereTagsAgreeElseOnItsThirdFrame) {
  for (const bool sees_one : {false, true}) {
    const Flight flight = CarriedElsewhere(sees_one);
    const WindowRun run = RunWindow(CourseSetup(), flight.measurements);
    ExpectAllFrames(run.current, 120);
    ExpectAllFrames(run.lagged, 120);
    if (sees_one) {
      for (const size_t i : {60u, 61u}) EXPECT_EQ(run.current[i].status, FrameStatus::kPredicted);
    }
    for (size_t i = sees_one ? 63 : 60; i < 120; ++i) {
      EXPECT_EQ(run.current[i].status, FrameStatus::kOk) << i << " " << sees_one;
      EXPECT_LT(
          PositionErrorM(run.current[i].state.world_from_body, flight.truth[i].world_from_body),
          0.01)
          << i << " " << sees_one;
    }
  }
}

// A host stamps frames as they arrive, in pairs: what moves between them would move at metres a
// second.
TEST(WindowChoice, FramesInBurstsGiveNoVelocityOfTheirOwn) {
  constexpr size_t kFrames = 200;
  Flight flight = Fly(CourseSetup().map, static_cast<int>(kFrames), 0.1, 1, Circle);
  for (size_t i = 0; i < kFrames; i += 2) {
    flight.measurements[i].t_ns = flight.measurements[i + 1].t_ns - 500'000;
  }
  const WindowRun run = RunWindow(CourseSetup(), flight.measurements);
  ASSERT_EQ(run.current.size(), kFrames);
  ASSERT_EQ(run.lagged.size(), kFrames);
  for (size_t i = 30; i < kFrames; ++i) {
    const double speed_mps = run.current[i].state.twist.v_world.norm();  // 0.6 in truth
    EXPECT_LT(speed_mps, 1) << i;
    EXPECT_LT(PositionErrorM(run.current[i].state.world_from_body, flight.truth[i].world_from_body),
              0.01)
        << i;
  }
}

// Under white noise on jerk such a drift along a circle is several sigmas. Longer than 0.8 s
// nothing says that a body that did not turn still does not.
TEST(WindowChoice, PredictionsWithoutTagsStayWithinTheirSigmas) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    Flight flight = Fly(CourseSetup().map, 400, 0.1, seed, Circle);
    for (size_t i = 320; i < 360; ++i) flight.measurements[i].tags.clear();
    const WindowRun run = RunWindow(CourseSetup(), flight.measurements);
    double last_sigma_m = 0;
    for (size_t i = 320; i < 360; ++i) {
      const FrameEstimate& frame = run.current[i];
      const StateVector error = Difference(frame.state, flight.truth[i]);
      const double sigma_m = std::sqrt(frame.covariance.block<3, 3>(3, 3).trace());
      EXPECT_EQ(frame.status, FrameStatus::kPredicted);
      EXPECT_GT(sigma_m, last_sigma_m) << i;
      for (int k = 0; k < 6; ++k) {
        EXPECT_LT(std::abs(error[k]), 3 * std::sqrt(frame.covariance(k, k))) << i << " " << k;
      }
      last_sigma_m = sigma_m;
    }
    EXPECT_LT(last_sigma_m, 0.8);  // and says something
  }
}

// A chain of states that nothing sees has no solution in the end; the window starts anew behind it.
TEST(WindowChoice, ALongStretchWithoutTagsEndsNothing) {
  constexpr size_t kFrom = 320, kTo = 1520, kFrames = 1700;
  Flight flight = Fly(CourseSetup().map, static_cast<int>(kFrames), 0.1, 1, Circle);
  for (size_t i = kFrom; i < kTo; ++i) flight.measurements[i].tags.clear();
  const WindowRun run = RunWindow(CourseSetup(), flight.measurements);
  ASSERT_EQ(run.current.size(), kFrames);
  ASSERT_EQ(run.lagged.size(), kFrames);
  for (size_t i = 0; i < kFrames; ++i) {
    EXPECT_EQ(run.current[i].t_ns, flight.measurements[i].t_ns) << i;
    EXPECT_EQ(run.lagged[i].t_ns, flight.measurements[i].t_ns) << i;
  }
  for (size_t i = kTo + 5; i < kFrames; ++i) {
    EXPECT_EQ(run.current[i].status, FrameStatus::kOk) << i;
    EXPECT_LT(PositionErrorM(run.current[i].state.world_from_body, flight.truth[i].world_from_body),
              0.01)
        << i;
  }
}

}  // namespace
}  // namespace tagtwist::internal::window_choice_test
