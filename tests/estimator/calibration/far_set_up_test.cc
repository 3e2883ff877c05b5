#include <gtest/gtest.h>

#include "estimator/calibration/calibration.h"
#include "estimator/report/files/calibration_text.h"
#include "frontend/types/so3.h"
#include "residuals/lens.h"
#include "tests/support/flights/calibration_flight.h"

namespace tagtwist::internal::far_set_up_test {
namespace {

// A set-up that is far off comes to where a right one comes to, and stays there.
TEST(SlowCalibration, AMountAndAWorldFromNothingAreAsGoodAsFromTheRightOnes) {
  const CalibrationFlight flight = DrawCalibrationFlight(ShortFlight());
  Config config = flight.config;
  Pose& mount = config.set_up.rig.front().cam_from_body;
  mount = MakePose(ExpSo3({0, 2.6, 1}) * mount.rotation(), {0.3, 0, 0});
  const Pose far = MakePose(ExpSo3({0.4, -0.3, 2.2}), {5, -3, 1});
  std::vector<TruthSample> truth = flight.ground_truth;
  for (TruthSample& sample : truth) sample.world_from_body = far * sample.world_from_body;
  const auto right =
      Calibrate(CalibrationInputOf(flight.config), flight.measurements, flight.ground_truth);
  const auto found = Calibrate(CalibrationInputOf(config), flight.measurements, truth);
  ASSERT_TRUE(right && found);
  const int first = LayoutOf(flight.truth).mount();
  const PoseStep apart = Difference(found->refined.cam_from_body, right->refined.cam_from_body);
  const PoseStep world =
      Difference(found->refined.truth_from_world, far * right->refined.truth_from_world);
  for (int i = 0; i < 6; ++i) {
    EXPECT_LT(std::abs(apart(i)), 0.5 * right->sigma(first + i)) << i;
    EXPECT_LT(std::abs(world(i)), 0.05) << i << ": the map as a whole is no better known";
    EXPECT_LT(found->sigma(first + i), 1.5 * right->sigma(first + i)) << i;
  }
  EXPECT_TRUE(Says(CalibrationText(*found), "mount (cam_from_body) turned by 1"));
  EXPECT_GT(found->validation.given.truth_median_rad, 0.5) << "as configured";
  EXPECT_NEAR(found->validation.refined.truth_median_m, right->validation.refined.truth_median_m,
              1e-4);
}

TEST(SlowCalibration, AFocalLengthThatIsFarOffComesToTheRightOneAndStays) {
  CalibrationFlightOptions options = ShortFlight();
  options.tag_position_sigma_m = options.tag_rotation_sigma_rad = 0;
  options.rows = 7;  // many tags a frame: some of them agree in a wrong lens
  options.columns = 6;
  options.errors = false;
  CalibrationFlight flight = DrawCalibrationFlight(options);
  flight.config.calibration.radial_sigma = flight.config.calibration.tangential_sigma = 0;
  const double focal_px = flight.truth.camera.fx;
  const auto right = Calibrate(CalibrationInputOf(flight.config), flight.measurements, {});
  ASSERT_TRUE(right);
  for (const double factor : {0.6, 1.6}) {
    Config config = flight.config;
    Camera& camera = config.set_up.rig.front().camera;
    camera.fx *= factor, camera.fy *= factor;
    const auto first = Calibrate(CalibrationInputOf(config), flight.measurements, {});
    ASSERT_TRUE(first) << first.error().message;
    const Camera& refined = first->set_up.rig.front().camera;
    EXPECT_NEAR(refined.fx, focal_px, 3 * first->sigma(kLogFocal) * focal_px) << factor;
    EXPECT_LT(first->sigma(kLogFocal), 0.003);
    EXPECT_EQ(first->views, right->views) << factor;
    config.set_up = first->set_up;
    const auto again = Calibrate(CalibrationInputOf(config), flight.measurements, {});
    ASSERT_TRUE(again) << again.error().message;
    EXPECT_NEAR(again->set_up.rig.front().camera.fx, refined.fx,
                0.5 * first->sigma(kLogFocal) * focal_px);
  }
}

}  // namespace
}  // namespace tagtwist::internal::far_set_up_test
