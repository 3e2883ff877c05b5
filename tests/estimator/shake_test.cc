// A camera that is shaken, with the blur that its shutter makes of it, and then held still.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/online/guidance.h"
#include "frontend/front_end.h"
#include "frontend/simulation/simulator.h"
#include "frontend/tags/tag_follower.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal::shake_test {
namespace {

constexpr double kIntervalS = 0.02, kShakeFromS = 0.5, kShakeToS = 0.82, kRampS = 0.04;
constexpr double kShutterS = 0.015, kFar = 0.01;  // [m]

double Smooth(double x) {
  const double c = std::clamp(x, 0.0, 1.0);
  return c * c * (3 - 2 * c);
}

// The camera's axis runs round a cone, so that no moment of it is still: 20 px in an exposure.
SplineTrajectory ShakenPath() {
  constexpr double kAngleRad = 0.1, kTurnRadps = 45;
  std::vector<TruthSample> poses;
  for (int i = 0; i <= 260; ++i) {
    const double t_s = 0.005 * i;
    const double share = Smooth((t_s - kShakeFromS) / kRampS) * Smooth((kShakeToS - t_s) / kRampS);
    const Eigen::Vector3d tilt(kAngleRad * share * std::cos(kTurnRadps * t_s),
                               kAngleRad * share * std::sin(kTurnRadps * t_s), 0);
    const Pose pose = MakePose(ExpSo3(tilt), Eigen::Vector3d(1.6 + 0.05 * t_s, 1.3, 1.1));
    poses.push_back({static_cast<int64_t>(1e9 * t_s), pose, {}});
  }
  SplineOptions options;
  options.knot_spacing_s = 0.01;
  options.regularisation = 1e-10;
  const auto path = SplineTrajectory::Fit(poses, options);
  EXPECT_TRUE(path);
  return *path;
}

struct Step {
  double t_s;
  FrameStatus status;
  double error_m;
};

std::vector<Step> Follow() {
  const EstimatorSetup setup = CourseSetup();
  SimulatorOptions options;
  options.exposure_s = kShutterS;
  options.renderer.supersampling = 2;
  const auto simulator = Simulator::Make(SetUpOf(setup), ShakenPath(), options);
  EXPECT_TRUE(simulator);
  auto follower = TagFollower::Create(SetUpOf(setup), {});
  EXPECT_TRUE(follower);
  FrontEnd front_end(SetUpOf(setup), {});
  SlidingWindow window(SetUpOf(setup), setup.options);
  std::vector<Step> out;
  for (int i = 1; kIntervalS * i < 1.2; ++i) {
    const double t_s = kIntervalS * i;
    const SimulatedFrame frame =
        simulator->MakeFrame(static_cast<uint64_t>(i), std::llround(1e9 * t_s));
    const auto tags = follower->Find(frame.image, PredictPose(window, frame.t_ns));
    const auto added = window.Add(front_end.Process(frame.t_ns, tags, frame.image));
    EXPECT_TRUE(added);
    const StateVector e = Difference(added->current.state, frame.truth);
    out.push_back({t_s, added->current.status, e.segment<3>(3).norm()});
  }
  return out;
}

TEST(Shake, SlowLostFramesAreMarkedAndTrackingIsBackWithinThreeSharpOnes) {
  const auto steps = Follow();
  int lost = 0, sharp = 0;
  for (const Step& step : steps) {
    const bool is_blurred = step.t_s > kShakeFromS + kRampS && step.t_s < kShakeToS - kRampS;
    const bool is_sharp = step.t_s - kShutterS / 2 > kShakeToS;
    if (is_blurred && step.status != FrameStatus::kOk) ++lost;
    if (step.status == FrameStatus::kOk) {
      EXPECT_LT(step.error_m, kFar) << step.t_s;
    }
    if (is_sharp && ++sharp >= 3) {
      EXPECT_EQ(step.status, FrameStatus::kOk) << step.t_s;
    }
  }
  EXPECT_GE(lost, 8) << "the shake is to hide the tags";
  EXPECT_GE(sharp, 15);
}

}  // namespace
}  // namespace tagtwist::internal::shake_test
