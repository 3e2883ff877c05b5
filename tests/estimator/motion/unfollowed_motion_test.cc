#include "estimator/motion/unfollowed_motion.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "frontend/types/so3.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::unfollowed_motion_test {
namespace {

constexpr size_t kFrames = 120;
constexpr double kSigmaPx = 0.3;  // of the draws' corners
constexpr MotionParts kBoth{true, true};

// Frames of a draw from one on, with states that are the truth moved and turned by what `off` says
// for a time [s], in [attitude; position].
template <class Off>
UnfollowedMotion Told(const SituationDraw& draw, size_t first, const Off& off,
                      double sigma_px = kSigmaPx) {
  UnfollowedMotion out;
  for (size_t k = first; k < first + kFrames; ++k) {
    const int64_t t_ns = draw.measurements[k].t_ns;
    const PoseStep step = off(ToSeconds(t_ns));
    const Pose& truth = draw.truth[k].world_from_body;
    const Pose state = MakePose(truth.rotation() * ExpSo3(step.head<3>()),
                                Eigen::Vector3d(truth.translation() + step.tail<3>()));
    const auto shown = ShownBy(draw.setup, sigma_px, t_ns, state, draw.measurements[k].tags);
    if (shown) out.Add(*shown);
  }
  return out;
}

PoseStep Nowhere(double /*t*/) { return PoseStep::Zero(); }

// And what is taken for the corners' noise does not matter.
TEST(UnfollowedMotion, AddsNothingToStatesThatAreTrue) {
  int added = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const SituationDraw draw = DrawSituation(Situation::kSmooth, seed);
    for (const size_t first : {0, 120, 240, 360}) {
      for (const double sigma_px : {0.1, 0.3, 0.9}) {
        added += Told(draw, first, Nowhere, sigma_px).Covariance(kBoth).trace() > 0 ? 1 : 0;
      }
    }
  }
  EXPECT_LE(added, 1);  // of 120, by chance
}

// The mean square of a vibration, and of its rate, along its direction; as much of what turns.
TEST(UnfollowedMotion, AddsWhatAVibrationIsOff) {
  const Eigen::Vector3d along = Eigen::Vector3d(2, -1, 2) / 3;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    const SituationDraw draw = DrawSituation(Situation::kSmooth, seed);
    for (const int first : {0, 3}) {
      const double size = first == 3 ? 3e-3 : 2.5e-3, hz = 4;  // m, or rad
      const UnfollowedMotion told = Told(draw, 0, [&](double t) {
        PoseStep out = PoseStep::Zero();
        out.segment<3>(first) = size * std::sin(2 * M_PI * hz * t) * along;
        return out;
      });
      const StateCovariance more = told.Covariance(kBoth);
      const int rate = first == 3 ? 6 : 9;
      const double found = along.dot(more.block<3, 3>(first, first) * along),
                   found_rate = along.dot(more.block<3, 3>(rate, rate) * along);
      EXPECT_NEAR(std::sqrt(found) / (size / std::sqrt(2)), 1, 0.35) << first;
      EXPECT_NEAR(std::sqrt(found_rate) / (2 * M_PI * hz * size / std::sqrt(2)), 1, 0.4) << first;
      EXPECT_EQ(Eigen::LLT<StateCovariance>(more + 1e-12 * StateCovariance::Identity()).info(),
                Eigen::Success);
      const MotionParts other{first != 3, first == 3};
      EXPECT_EQ(told.Covariance(other).block(first, first, 3, 3).norm(), 0);
    }
  }
}

// What happens in one frame is no scatter; nor is there any in frames that show one tag.
TEST(UnfollowedMotion, AddsNothingForOneFrameOrLoneTags) {
  SituationDraw draw = DrawSituation(Situation::kSmooth, 6);
  const double at_s = ToSeconds(draw.measurements[60].t_ns);
  const auto leap = [&](double t) {
    PoseStep out = PoseStep::Zero();
    if (std::abs(t - at_s) < 1e-3) out(3) = 0.3;
    return out;
  };
  EXPECT_EQ(Told(draw, 0, leap).Covariance(kBoth).norm(), 0);
  for (FrameMeasurements& frame : draw.measurements) {
    frame.tags.resize(std::min<size_t>(frame.tags.size(), 1));
  }
  const auto off = [](double t) { return PoseStep(PoseStep::Constant(0.02 * std::sin(20 * t))); };
  EXPECT_EQ(Told(draw, 0, off).Covariance(kBoth).norm(), 0);
}

// Faded or in pieces it is the same where the frames are alike.
TEST(UnfollowedMotion, IsTheSameInPieces) {
  const SituationDraw draw = DrawSituation(Situation::kSmooth, 7);
  const auto shaken = [](double t) {
    PoseStep out = PoseStep::Zero();
    out(4) = 4e-3 * std::sin(25 * t);
    return out;
  };
  UnfollowedMotion pieces = Told(draw, 0, shaken);
  pieces += Told(draw, kFrames, shaken);
  const StateCovariance whole = pieces.Covariance(kBoth);
  pieces.Fade(0.5);
  const StateCovariance faded = pieces.Covariance(kBoth);
  EXPECT_NEAR(faded(4, 4) / whole(4, 4), 1, 0.1);
  EXPECT_NEAR(std::sqrt(whole(4, 4)), 4e-3 / std::sqrt(2), 1e-3);
}

}  // namespace
}  // namespace tagtwist::internal::unfollowed_motion_test
