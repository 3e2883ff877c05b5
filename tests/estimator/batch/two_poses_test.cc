// A small tag of a plane looks alike from two poses: what a batch says of frames that leave both
// open, by draws with exact truth.
#include "estimator/batch/two_poses.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "estimator/batch/batch.h"
#include "estimator/report/findings/findings.h"
#include "estimator/report/findings/verdict.h"
#include "frontend/types/nees.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::two_poses_test {
namespace {

constexpr int kTag = 54;
constexpr int64_t kIntervalNs = 33333333;

// From where the tag's centre is seen.
struct View {
  double distance_m = 2, tilt_rad = 0.4, azimuth_rad = 0, roll_rad = 0, off_axis_rad = 0.1;
};

View DrawView(unsigned seed, double nearest_m, double farthest_m) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> uniform(0, 1);
  View out;
  out.distance_m = nearest_m + (farthest_m - nearest_m) * uniform(engine);
  out.tilt_rad = 0.15 + 0.85 * uniform(engine);
  out.azimuth_rad = 6.28 * uniform(engine);
  out.roll_rad = 6.28 * uniform(engine);
  return out;
}

Pose BodyAt(const EstimatorSetup& setup, const View& view) {
  const double tilt = view.tilt_rad, azimuth = view.azimuth_rad;
  const Eigen::Vector3d towards(std::sin(tilt) * std::cos(azimuth),
                                std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
  const Eigen::Vector3d x(-std::sin(azimuth), std::cos(azimuth), 0), z = -towards;
  Eigen::Matrix3d rotation;
  rotation << x, z.cross(x), z;
  rotation = rotation * ExpSo3({0, 0, view.roll_rad}) * ExpSo3({view.off_axis_rad, 0, 0});
  const Eigen::Vector3d centre = setup.map.Find(kTag)->world_from_tag.translation();
  return MakePose(Eigen::Quaterniond(rotation), centre + view.distance_m * towards) *
         setup.cam_from_body;
}

struct Recording {
  SetUp set_up = CourseSetUp();
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
};

// Of one tag where `alone` says so of the frame's time, else of all that are in view.
Recording Record(
    int frames, unsigned seed, const std::function<View(double)>& view_at,
    const std::function<bool(double)>& alone = [](double) { return true; }) {
  constexpr double kNoisePx = 0.2, kStepS = 1e-4;
  Recording out;
  const EstimatorSetup setup = CourseSetup();
  const TagMap one(setup.map.family(), {*setup.map.Find(kTag)});
  for (int k = 0; k < frames; ++k) {
    const double t_s = 1e-9 * static_cast<double>(k * kIntervalNs);
    BodyState state;
    state.world_from_body = BodyAt(setup, view_at(t_s));
    state.twist = TwistBetween(BodyAt(setup, view_at(t_s - kStepS)),
                               BodyAt(setup, view_at(t_s + kStepS)), 2 * kStepS);
    FrameMeasurements m;
    m.t_ns = k * kIntervalNs;
    m.tags = SeeTags(alone(t_s) ? one : setup.map, setup.camera,
                     setup.cam_from_body * Inverse(state.world_from_body), kNoisePx,
                     1000 * seed + static_cast<unsigned>(k));
    out.truth.push_back(state);
    out.measurements.push_back(std::move(m));
  }
  return out;
}

// What many recordings' frames say of themselves against truth.
struct Tally {
  int frames = 0, beyond = 0, ambiguous = 0, wrong = 0, wrong_unsaid = 0;
  double nees = 0;  // of the pose, per degree of freedom

  void Add(const Recording& recording, const Estimate& estimate) {
    ASSERT_EQ(estimate.frames.size(), recording.truth.size());
    for (size_t k = 0; k < estimate.frames.size(); ++k) {
      const FrameEstimate& frame = estimate.frames[k];
      const BodyState& truth = recording.truth[k];
      const auto of_pose = Nees(truth, frame.state, frame.covariance, kPoseEntries);
      ASSERT_TRUE(of_pose);
      nees += *of_pose / 6;
      for (const int first : kWholeState) {  // 5 sigma of three entries
        const auto block = Nees<1>(truth, frame.state, frame.covariance, {first});
        ASSERT_TRUE(block);
        if (*block > 31.8) {
          ++beyond;
          break;
        }
      }
      const bool is_wrong =
          RotationErrorRad(frame.state.world_from_body, truth.world_from_body) > 0.3;
      const bool says = frame.status == FrameStatus::kAmbiguous;
      ++frames, ambiguous += says ? 1 : 0, wrong += is_wrong ? 1 : 0;
      wrong_unsaid += is_wrong && !says ? 1 : 0;
    }
  }
  void ExpectHonest() const {
    ASSERT_GT(frames, 0);
    EXPECT_GT(nees / frames, 0.5);
    EXPECT_LT(nees / frames, 2);
    EXPECT_LE(beyond, 0.01 * frames);
    EXPECT_EQ(wrong_unsaid, 0);
  }
};

Estimate Solve(const Recording& recording) {
  auto out = RunBatch(recording.set_up, {}, recording.measurements);
  EXPECT_TRUE(out) << (out ? "" : out.error().message);
  return out ? std::move(*out) : Estimate();
}

TEST(TwoPoses, APhotoOfATagHasBothInItsCovariance) {
  Tally tally;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    const View view = DrawView(seed, 1.5, 4);
    const Recording photo = Record(1, seed, [&](double) { return view; });
    tally.Add(photo, Solve(photo));
  }
  tally.ExpectHonest();
  EXPECT_GT(tally.wrong, 4);  // nobody can know which
  EXPECT_GT(tally.ambiguous, 30);
}

TEST(TwoPoses, AStillCameraFarFromATagNeverKnows) {
  Tally tally;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const View view = DrawView(seed, 5, 8);
    const Recording still = Record(30, seed, [&](double) { return view; });
    tally.Add(still, Solve(still));
  }
  tally.ExpectHonest();
  EXPECT_GT(tally.ambiguous, tally.frames / 2);
}

TEST(TwoPoses, ASlowFlightBeforeATagIsHonest) {
  Tally tally;
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const View view = DrawView(seed, 4, 7);
    const Recording slow = Record(60, seed, [&](double t_s) {
      View at = view;
      at.tilt_rad += 0.05 * t_s;
      return at;
    });
    tally.Add(slow, Solve(slow));
  }
  tally.ExpectHonest();
  EXPECT_GT(tally.ambiguous, 0);
}

// Between frames that see more tags a body would have had to jump.
TEST(TwoPoses, SlowFramesBeforeAndAfterDecide) {
  const auto alone = [](double t_s) { return t_s > 0.5 && t_s < 1.5; };
  for (unsigned seed = 1; seed <= 2; ++seed) {
    View view = DrawView(seed, 3, 4);
    view.tilt_rad = 0.5;
    const auto at = [&](double t_s) {
      View out = view;
      out.tilt_rad += 0.05 * std::sin(2 * t_s);
      return out;
    };
    const Recording flight = Record(60, seed, at, alone);
    Tally tally;
    const Estimate estimate = Solve(flight);
    tally.Add(flight, estimate);
    EXPECT_EQ(tally.wrong, 0);
    EXPECT_EQ(tally.ambiguous, 0);
    EXPECT_LE(tally.beyond, 1);
  }
}

TEST(TwoPoses, AFlightOverTheMatIsNotSearched) {
  const ExactModelFlight flight = DrawFlight(ModelUnder(WhiteNoiseOn::kJerk, 3));
  const auto frames = RunBatch(CourseSetUp(), {}, flight.measurements)->frames;
  EXPECT_TRUE(std::all_of(frames.begin(), frames.end(), [](const FrameEstimate& frame) {
    return frame.status == FrameStatus::kOk;
  }));
}

TEST(TwoPoses, TheVerdictSaysSo) {
  const Recording photo = Record(1, 3, [](double) { return View{3.5, 0.5, 1, 2, 0.1}; });
  const Estimate estimate = Solve(photo);
  ASSERT_EQ(estimate.frames.front().status, FrameStatus::kAmbiguous);
  const auto findings = Findings(estimate, {}, photo.set_up.map, {});
  const std::string verdict = VerdictText(estimate, findings, {});
  EXPECT_NE(verdict.find("not to be relied on"), std::string::npos) << verdict;
  EXPECT_NE(verdict.find("two poses open"), std::string::npos) << verdict;
}

TEST(TwoPoses, AFrameThatSeesNothingIsAsOpenAsItsNeighbours) {
  std::vector<FrameEstimate> frames(6);
  for (FrameEstimate& frame : frames) frame.status = FrameStatus::kOk;
  const std::vector<FrameRange> around = {{-1, 0}, {0, 0}, {0, 1}, {1, 1}, {1, 2}, {2, 2}};
  TellAmbiguous({false, true, false}, around, &frames);
  std::vector<bool> open;
  for (const FrameEstimate& frame : frames) {
    open.push_back(frame.status == FrameStatus::kAmbiguous);
  }
  EXPECT_EQ(open, (std::vector<bool>{false, false, true, true, true, false}));
}

}  // namespace
}  // namespace tagtwist::internal::two_poses_test
