#include "estimator/calibration/normals.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "frontend/types/so3.h"
#include "tests/support/flights/calibration_flight.h"

namespace tagtwist::internal::normals_test {
namespace {

struct Scene {
  CalibrationFlight flight;
  CalibrationProblem problem;
  CalibrationNoise noise;

  Scene() {
    CalibrationFlightOptions options;
    options.rows = 3;
    options.columns = 3;
    options.frames = 24;
    flight = DrawCalibrationFlight(options);
    auto made = MakeCalibrationProblem(CalibrationInputOf(flight.config), flight.measurements, {});
    EXPECT_TRUE(made) << made.error().message;
    problem = *made;
    problem.robust_scale = 1e6;  // the cost is quadratic then, but for the projection
    SetCornerNoise(noise.corner_sigma_px, &problem.frames);
  }
  CalibrationNormals At(const CalibrationState& state,
                        const std::vector<CalibrationFrame>& frames) const {
    return LinearizeCalibration(problem, state, frames, noise, 0);
  }
};

// With the poses known nothing is eliminated: the gradient is that of the cost.
TEST(CalibrationNormals, GradientMatchesNumericDifferences) {
  Scene scene;
  std::vector<CalibrationFrame> frames = scene.problem.frames;
  for (CalibrationFrame& frame : frames) frame.pose_known = true;
  const CalibrationNormals at = scene.At(scene.problem.prior, frames);
  ASSERT_TRUE(at.ok);
  int checked = 0;
  for (Eigen::Index i = 0; i < scene.problem.prior_sigmas.size(); ++i) {
    if (!(scene.problem.prior_sigmas(i) > 0)) continue;
    const double h = 1e-3 / std::sqrt(at.information(i, i));
    Eigen::VectorXd step = Eigen::VectorXd::Zero(scene.problem.prior_sigmas.size());
    step(i) = h;
    const double up = scene.At(Retract(scene.problem.prior, step), frames).cost;
    const double down = scene.At(Retract(scene.problem.prior, -step), frames).cost;
    EXPECT_NEAR((up - down) / (2 * h), at.gradient(i),
                1e-4 * (std::abs(at.gradient(i)) + std::sqrt(at.information(i, i))))
        << i;
    ++checked;
  }
  EXPECT_GT(checked, 20);
}

// What the eliminated poses are said to do is what they do.
TEST(CalibrationNormals, MovingThePosesTakesOffWhatIsSaid) {
  Scene scene;
  std::vector<CalibrationFrame> frames = scene.problem.frames;
  const CalibrationNormals before = scene.At(scene.problem.prior, frames);
  ASSERT_TRUE(before.ok);
  ASSERT_EQ(before.frames.size(), frames.size());
  ASSERT_GT(before.pose_gain, 0);
  for (size_t i = 0; i < frames.size(); ++i) {
    const Eigen::Matrix<double, 6, 1> step = -before.frames[i].offset;
    Pose& pose = frames[i].world_from_cam;
    pose = MakePose(pose.rotation() * ExpSo3(step.head<3>()), pose.translation() + step.tail<3>());
  }
  const CalibrationNormals after = scene.At(scene.problem.prior, frames);
  ASSERT_TRUE(after.ok);
  EXPECT_NEAR((before.cost - after.cost) / before.pose_gain, 1, 0.05);
  EXPECT_LT(after.pose_gain, 0.05 * before.pose_gain);
  const Eigen::LLT<Eigen::MatrixXd> llt(
      after.information +
      Eigen::MatrixXd::Identity(after.information.rows(), after.information.cols()));
  EXPECT_EQ(llt.info(), Eigen::Success);
}

}  // namespace
}  // namespace tagtwist::internal::normals_test
