// What is given of a lens and its mount: what each of their entries does to the corners, and that
// the covariances of the states have it.
#include "estimator/systematic/given_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "estimator/batch/batch.h"
#include "estimator/systematic/systematic_basis.h"
#include "estimator/window/sliding_window.h"
#include "residuals/lens.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/simulated_flight.h"

namespace tagtwist::internal::given_errors_test {
namespace {

using testing::AllOf;
using testing::Gt;
using testing::Lt;

// That camera with an error: a step of its lens and of its mount.
RigCamera Off(RigCamera camera, const Eigen::VectorXd& step) {
  camera.camera = PerturbLens(camera.camera, step.head(step.size() - 6));
  camera.cam_from_body = Retract(camera.cam_from_body, step.tail<6>());
  return camera;
}

// Standard deviations that move corners by about a pixel each.
Eigen::VectorXd SigmasOf(const Camera& camera) {
  const Eigen::Index lens = LensSize(camera);
  Eigen::VectorXd out(lens + 6);
  out.head(4) << 0.005, 0.005, 1, 1;
  out.segment(4, lens - 4).setConstant(0.01);
  out.tail(6) << 3e-3, 3e-3, 3e-3, 3e-3, 3e-3, 3e-3;
  return out;
}

// The last column of a tag's terms, and what it must be by differences: predicted corners of the
// camera that is off by a hundredth of it either way, all in units of the noise.
void ExpectColumnAsByDifferences(const SetUp& set_up, const Pose& world_from_body,
                                 const TagDetection& tag, Eigen::Index entry) {
  constexpr double kStep = 0.01;
  const auto terms = [&](const RigCamera& camera) {
    SetUp off = set_up;
    off.rig.front() = camera;
    SystematicBasis::TagTerms out;
    EXPECT_TRUE(SystematicBasis(MakeEstimatorSetup(off, {}), {})
                    .Linearize(NoiseModel(), world_from_body, tag, &out));
    return out;
  };
  RigCamera given = set_up.rig.front();
  const double sigma = SigmasOf(given.camera)(entry);
  given.covariance.setZero(SigmasOf(given.camera).size(), SigmasOf(given.camera).size());
  given.covariance(entry, entry) = sigma * sigma;
  const Eigen::VectorXd column = terms(given).by_parameters.rightCols<1>();
  Eigen::VectorXd step = Eigen::VectorXd::Zero(given.covariance.rows());
  step(entry) = kStep * sigma;
  const Eigen::VectorXd by_differences = (terms(Off(set_up.rig.front(), step)).residual -
                                          terms(Off(set_up.rig.front(), -step)).residual) /
                                         (2 * kStep);
  ASSERT_GT(by_differences.norm(), 1e-3);
  const double sign = column.dot(by_differences) < 0 ? -1 : 1;  // a root is one up to its sign
  EXPECT_LT((sign * column - by_differences).norm(), 1e-3 * by_differences.norm()) << entry;
}

TEST(GivenErrors, MoveCornersAsTheErrorsThemselves) {
  const SimulatedFlight flight = SimulateCorners("agile", 1, 30);
  auto set_up = CourseSetUp();
  set_up.rig.front().camera.k1 = -0.1;
  const Pose pose = flight.truth[9].world_from_body;
  const TagDetection& tag = flight.measurements[9].tags.at(2);
  auto standing = set_up;  // the same view of a body that carries the mat before a camera in W
  standing.rig.mounted_on = MountedOn::kWorld;
  const Pose world_from_body = MakePose(Eigen::Quaterniond(0.9, 0.1, -0.3, 0.2), {0.3, -0.5, 0.7});
  standing.rig.front().cam_from_body =
      set_up.rig.front().cam_from_body * Inverse(pose) * Inverse(world_from_body);
  for (Eigen::Index i = 0; i < LensSize(set_up.rig.front().camera) + 6; ++i) {
    ExpectColumnAsByDifferences(set_up, pose, tag, i);
    ExpectColumnAsByDifferences(standing, world_from_body, tag, i);
  }
}

// Correlations between a lens and a mount need the signs of both to be right.
TEST(GivenErrors, OfALensAndAMountThatMakeUpForOneAnotherMoveNothing) {
  const SimulatedFlight flight = SimulateCorners("hover", 1, 30);
  auto set_up = CourseSetUp();
  RigCamera& camera = set_up.rig.front();
  const Eigen::Index lens = LensSize(camera.camera);
  Eigen::VectorXd root = Eigen::VectorXd::Zero(lens + 6);
  root(kCentreX) = 2;  // px; the axis turned by as much, about the camera's y in the body
  root.segment<3>(lens) =
      camera.cam_from_body.rotation().conjugate() * Eigen::Vector3d(0, -2 / camera.camera.fx, 0);
  for (const double sign : {1.0, -1.0}) {
    root.segment<3>(lens) *= sign;
    camera.covariance = root * root.transpose();
    SystematicBasis::TagTerms terms;
    ASSERT_TRUE(SystematicBasis(MakeEstimatorSetup(set_up, {}), {})
                    .Linearize(NoiseModel(), flight.truth[5].world_from_body,
                               flight.measurements[5].tags.at(0), &terms));
    const double moved = terms.by_parameters.rightCols<1>().norm();
    EXPECT_THAT(moved, sign > 0 ? testing::Matcher<double>(Lt(4)) : Gt(10)) << sign;
  }
}

TEST(GivenErrors, TheOptionsFocalSigmaTakesThePlaceOfTheCameras) {
  EstimatorSetup setup = CourseSetup();
  const Eigen::Index n = LensSize(setup.camera) + 6;
  setup.camera_covariance.setZero(n, n);
  setup.camera_covariance(0, 0) = 0.01 * 0.01;
  setup.camera_covariance(2, 2) = 4;
  setup.camera_covariance(0, 2) = setup.camera_covariance(2, 0) = 0.9 * 0.01 * 2;
  Eigen::MatrixXd root = RootOfGiven(setup.CameraOf(0), {});
  EXPECT_LT((root * root.transpose() - setup.camera_covariance).norm(), 1e-12);
  EstimatorOptions options;
  options.focal_sigma = 0.03;
  root = RootOfGiven(setup.CameraOf(0), options);
  EXPECT_EQ(root.cols(), 2);
  EXPECT_NEAR(root.row(0).squaredNorm(), 9e-4, 1e-12);
  EXPECT_NEAR(root.row(0).dot(root.row(2)), 0, 1e-12);
  options.focal_sigma = 0;
  EXPECT_EQ(RootOfGiven(setup.CameraOf(0), options).row(0).norm(), 0);
}

// A set-up that is off by a draw of what it says of itself: focal length, centre and the first
// coefficient, correlated, and a mount that was found with that centre.
SetUp DrawSetUp(std::mt19937* random) {
  SetUp out = CourseSetUp();
  RigCamera& camera = out.rig.front();
  const Eigen::Index lens = LensSize(camera.camera), n = lens + 6;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(n, n);
  root(kLogFocal, 0) = 0.02;
  root(kCentreX, 1) = root(kCentreY, 2) = 3;
  root(kFirstDistortion, 0) = -0.01;
  root(kFirstDistortion, 3) = 0.01;
  root.diagonal().tail<6>() << 5e-3, 5e-3, 5e-3, 4e-3, 4e-3, 4e-3;
  root(lens, 2) = 3 / camera.camera.fy;
  std::normal_distribution<double> normal;
  Eigen::VectorXd step(n);
  for (double& value : step) value = normal(*random);
  camera = Off(camera, root * step);
  camera.covariance = root * root.transpose();
  return out;
}

// Of the poses, a degree of freedom, from the second second on.
double PoseNees(const std::vector<FrameEstimate>& frames, const std::vector<BodyState>& truth) {
  double sum = 0;
  int n = 0;
  for (size_t i = 30; i < truth.size(); ++i, ++n) {
    const Eigen::Matrix<double, 6, 1> error =
        Difference(truth[i].world_from_body, frames.at(i).state.world_from_body);
    const PoseCovariance covariance = frames[i].covariance.topLeftCorner<6, 6>();
    sum += error.dot(covariance.inverse() * error) / 6;
  }
  return sum / n;
}

TEST(GivenErrors, SlowAreInTheCovariancesOverDraws) {
  const SimulatedFlight flight = SimulateCorners("figure8", 3, 30);
  std::mt19937 random(5);
  double batch = 0, without = 0, lagged = 0;
  constexpr int kRuns = 16;
  for (int i = 0; i < kRuns; ++i) {
    auto set_up = DrawSetUp(&random);
    const auto with = RunBatch(set_up, {}, flight.measurements);
    ASSERT_TRUE(with);
    batch += PoseNees(with->frames, flight.truth) / kRuns;
    SlidingWindow window(set_up, {});
    std::vector<FrameEstimate> of_window;
    for (const FrameMeasurements& measurement : flight.measurements) {
      const auto out = window.Add(measurement);
      ASSERT_TRUE(out);
      of_window.insert(of_window.end(), out->lagged.begin(), out->lagged.end());
    }
    for (const FrameEstimate& frame : window.Finish()) of_window.push_back(frame);
    lagged += PoseNees(of_window, flight.truth) / kRuns;
    set_up.rig.front().covariance.resize(0, 0);
    const auto alone = RunBatch(set_up, {}, flight.measurements);
    ASSERT_TRUE(alone);
    without += PoseNees(alone->frames, flight.truth) / kRuns;
    for (size_t k = 0; k < alone->frames.size(); ++k) {  // it is the covariance alone that knows
      EXPECT_EQ(with->frames[k].state.world_from_body.params,
                alone->frames[k].state.world_from_body.params);
    }
  }
  EXPECT_THAT(batch, AllOf(Gt(0.5), Lt(1.6)));
  EXPECT_THAT(lagged, AllOf(Gt(0.4), Lt(2)));
  EXPECT_GT(without, 10);
  RecordProperty("batch", std::to_string(batch));
  RecordProperty("lagged", std::to_string(lagged));
  RecordProperty("without", std::to_string(without));
}

}  // namespace
}  // namespace tagtwist::internal::given_errors_test
