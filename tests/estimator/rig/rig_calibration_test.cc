#include "estimator/batch/rig/rig_calibration.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "frontend/types/so3.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/rig_flights.h"

namespace tagtwist::internal::rig_calibration_test {
namespace {

using ::testing::HasSubstr;

constexpr MountPriors kPriors{0.03, 0.03, 0.02};

// All cameras of the rig at once, or one after another; the stamps of each by a clock of its own,
// to which its offset is to be added.
ExactModelFlight Fly(const SetUp& set_up, const ExactModelOptions& model, bool at_once,
                     const std::array<double, 3>& offsets_s) {
  ExactModelFlight out = DrawFlight(model);
  std::vector<FrameMeasurements> frames;
  for (size_t i = 0; i < out.truth.size(); ++i) {
    const int64_t t_ns = out.measurements[i].t_ns;
    for (int camera = 0; camera < 3; ++camera) {
      if (!at_once && static_cast<int>(i % 3) != camera) continue;
      const auto seed =
          static_cast<unsigned>(1000 * model.random_seed + 3 * i) + static_cast<unsigned>(camera);
      const int64_t stamp_ns = t_ns - std::llround(1e9 * offsets_s[static_cast<size_t>(camera)]);
      if (frames.empty() || frames.back().t_ns != stamp_ns) {
        frames.emplace_back();
        frames.back().t_ns = stamp_ns;
      }
      for (const TagDetection& tag : SeenByCamera(set_up, camera, out.truth[i].world_from_body,
                                                  model.corner_sigma_px, seed)) {
        frames.back().tags.push_back(tag);
      }
    }
  }
  out.measurements = std::move(frames);
  return out;
}

// Mounts as nobody would believe them.
SetUp Unknown(const SetUp& set_up) {
  SetUp out = set_up;
  for (size_t i = 1; i < 3; ++i) {
    Pose& mount = out.rig.cameras[i].cam_from_body;
    mount = mount * MakePose(ExpSo3({0.4, -0.3, 1.0}), {0.1, -0.2, 0.15});
  }
  return out;
}

struct Misfits {
  double nees = 0;  // a degree of freedom
  int n = 0;
  double largest_rad = 0, largest_m = 0, largest_s = 0;
};

void Add(const RigCalibration& found, const SetUp& truth, const std::array<double, 3>& offsets_s,
         Misfits* out) {
  for (size_t i = 1; i < 3; ++i) {
    const RigCamera& camera = found.set_up.rig.cameras[i];
    const MountFound& own = found.cameras[i - 1];
    const PoseStep d = Difference(camera.cam_from_body, truth.rig.cameras[i].cam_from_body);
    const double clock_s = own.clock_s - offsets_s[i];
    out->nees += d.dot(camera.covariance.bottomRightCorner<6, 6>().llt().solve(d)) +
                 std::pow(clock_s / own.clock_sigma_s, 2);
    out->n += MountBorder::kEntries;
    out->largest_rad = std::max(out->largest_rad, d.head<3>().norm());
    out->largest_m = std::max(out->largest_m, d.tail<3>().norm());
    out->largest_s = std::max(out->largest_s, std::abs(clock_s));
    EXPECT_TRUE(own.unseen.empty()) << own.unseen.front();
  }
}

void ExpectFound(bool at_once, const std::array<double, 3>& offsets_s) {
  constexpr int kDraws = 5;
  const SetUp truth = RigOfThree();
  Misfits all;
  for (int draw = 0; draw < kDraws; ++draw) {
    ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk);
    model.frames = 180;
    model.random_seed = 30 + static_cast<unsigned>(draw);
    const ExactModelFlight flight = Fly(truth, model, at_once, offsets_s);
    const auto found = CalibrateRig(Unknown(truth), {}, kPriors, flight.measurements);
    ASSERT_TRUE(found) << found.error().message;
    Add(*found, truth, offsets_s, &all);
  }
  EXPECT_GT(all.nees / all.n, 0.5);
  EXPECT_LT(all.nees / all.n, 1.6);
  EXPECT_LT(all.largest_rad, 0.003);
  EXPECT_LT(all.largest_m, 0.004);
  EXPECT_LT(all.largest_s, 0.002);
}

TEST(RigCalibration, SlowFindsMountsOfCamerasThatSeeAtOnce) { ExpectFound(true, {0, 0, 0}); }

TEST(RigCalibration, SlowFindsMountsAndClocksOfCamerasThatSeeInTurn) {
  ExpectFound(false, {0, 0.007, -0.013});
}

TEST(RigCalibration, HoldsWhatIsToBeHeldAndNamesWhoSeesNothing) {
  const tagtwist::SetUp truth = RigOfThree();
  ExactModelOptions model = ModelUnder(WhiteNoiseOn::kJerk);
  model.frames = 60;
  ExactModelFlight flight = Fly(truth, model, true, {0, 0, 0});
  tagtwist::SetUp off = truth;
  off.rig.cameras[1].cam_from_body =
      truth.rig.cameras[1].cam_from_body * MakePose(ExpSo3({0.01, 0, 0}), {0.01, 0, 0});
  const auto held = CalibrateRig(off, {}, {0.03, 0, 0}, flight.measurements);
  ASSERT_TRUE(held) << held.error().message;
  EXPECT_GT(held->cameras[0].change.head<3>().norm(), 0.005);
  EXPECT_LT(held->cameras[0].change.tail<3>().norm(), 0.002);  // the turn moves it a little
  EXPECT_EQ(held->cameras[0].clock_sigma_s, 0);
  for (FrameMeasurements& frame : flight.measurements) {
    frame.tags.erase(std::remove_if(frame.tags.begin(), frame.tags.end(),
                                    [](const TagDetection& tag) { return tag.camera == 2; }),
                     frame.tags.end());
  }
  const auto blind = CalibrateRig(truth, {}, kPriors, flight.measurements);
  ASSERT_FALSE(blind);
  EXPECT_THAT(blind.error().message, HasSubstr("cam2: sees no tag of the map"));
}

}  // namespace
}  // namespace tagtwist::internal::rig_calibration_test
