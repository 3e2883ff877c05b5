// A lens of which nothing is known, from drawn corners of a sheet.
#include "residuals/lens.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "estimator/calibration/lens/lens_from_nothing.h"
#include "estimator/calibration/lens/lens_start.h"
#include "estimator/report/files/camera_found.h"
#include "tests/estimator/calibration/drawn_views.h"

namespace tagtwist::internal::lens_test {
namespace {

using namespace drawn_views;

using ::testing::Contains;
using ::testing::HasSubstr;

Result<LensFound> Find(const std::vector<FrameMeasurements>& frames, const TagMap& map) {
  const auto starts = StartLens(frames, map, 640, 480);
  if (!starts) return starts.error();
  return FindLens(frames, map, *starts);
}

TEST(FocalLength, ByHomographiesIsExactAndNoneFaceOn) {
  const Camera camera = CameraOf(400, LensModel::kRadialTangential);
  std::vector<Eigen::Matrix3d> tilted, face_on;
  for (const double angle : {0.3, 0.8, -0.5}) {
    for (const bool is_tilted : {true, false}) {
      const Eigen::Vector3d axis =
          is_tilted ? Eigen::Vector3d(1, angle, 0).normalized() : Eigen::Vector3d::UnitZ();
      Eigen::Matrix3d plane = Eigen::AngleAxisd(angle, axis).toRotationMatrix();
      plane.col(2) = Eigen::Vector3d(0.1, -0.2, 1.5);
      Eigen::Matrix3d k = Eigen::Matrix3d::Identity();
      k(0, 0) = k(1, 1) = camera.fx, k(0, 2) = camera.cx, k(1, 2) = camera.cy;
      (is_tilted ? tilted : face_on).emplace_back(-3 * k * plane);
    }
  }
  const Eigen::Vector2d centre(camera.cx, camera.cy);
  const auto focal_px = FocalLengthByHomographies(tilted, centre);
  ASSERT_TRUE(focal_px);
  EXPECT_NEAR(*focal_px, 400, 1e-9);
  EXPECT_FALSE(FocalLengthByHomographies(face_on, centre));
  EXPECT_FALSE(FocalLengthByHomographies({}, centre));
}

class LensFromNothing : public testing::TestWithParam<Case> {};

TEST_P(LensFromNothing, IsTheTruthWithinItsSigmas) {
  const TagMap map = Sheet();
  const Camera truth = TruthOf(GetParam());
  std::pair<int, int> outside{0, 0};
  for (const unsigned seed : {1U, 2U}) {
    Draw draw;
    draw.seed = seed;
    const auto found = Find(DrawFrames(truth, map, draw), map);
    ASSERT_TRUE(found) << found.error().message;
    ExpectGood(*found, truth, &outside);
  }
  EXPECT_GE(outside.second, 8);
  EXPECT_LE(outside.first, 1) << "of " << outside.second;
}
INSTANTIATE_TEST_SUITE_P(Lenses, LensFromNothing,
                         testing::Values(Case{"pinhole", 690, LensModel::kRadialTangential, 0, 0}),
                         [](const auto& of) { return std::string(of.param.name); });
INSTANTIATE_TEST_SUITE_P(
    SlowLenses, LensFromNothing,
    testing::Values(Case{"barrel", 330, LensModel::kRadialTangential, -0.25, 0.06},
                    Case{"fisheye", 230, LensModel::kEquidistant, 0.02, -0.01}),
    [](const auto& of) { return std::string(of.param.name); });

TEST(SlowLensFromNothing, KnowsTheLineTimeOfARollingShutter) {
  const TagMap map = Sheet();
  const Camera truth = CameraOf(450, LensModel::kRadialTangential);
  Draw draw;
  draw.pairs = true;
  draw.line_time_s = 4e-5;
  const auto found = Find(DrawFrames(truth, map, draw), map);
  ASSERT_TRUE(found) << found.error().message;
  ASSERT_TRUE(found->besides.line_time);
  const double sigma_s =
      found->inflation() * found->calibration.sigma(LayoutOf(found->calibration.given).line_time());
  EXPECT_LT(sigma_s, 4e-6);
  EXPECT_NEAR(found->calibration.set_up.rig.front().line_time_s, 4e-5, 3.5 * sigma_s);
  EXPECT_THAT(CameraFoundConfig(*found), HasSubstr("line_time_s: "));
  // Half a millisecond an image is no rolling shutter, however clearly it is seen.
  draw.line_time_s = 1e-6;
  draw.corner_sigma_px = 0.01;
  const auto global = Find(DrawFrames(truth, map, draw), map);
  ASSERT_TRUE(global) << global.error().message;
  EXPECT_FALSE(global->besides.line_time);
}

TEST(Views, SayWhatIsMissing) {
  const TagMap map = Sheet();
  const Camera camera = CameraOf(450, LensModel::kRadialTangential);
  Draw draw;
  draw.tilt_rad = 0.03;
  const auto flat = StartLens(DrawFrames(camera, map, draw), map, 640, 480);
  ASSERT_TRUE(flat);
  EXPECT_THAT(flat->missing, Contains(HasSubstr("tilt them more")));

  // Twenty frames that are nearly equal.
  draw.tilt_rad = 0.7;
  std::vector<FrameMeasurements> alike;
  for (unsigned i = 0; i < 20; ++i) {
    Draw one = draw;
    one.views = 1;
    auto frames = DrawFrames(camera, map, one);
    frames.front().t_ns = 1000000000LL * i;
    for (TagDetection& tag : frames.front().tags) {
      for (Eigen::Vector2d& corner : tag.corners) corner.x() += 0.02 * i;
    }
    alike.push_back(frames.front());
  }
  const auto same = StartLens(alike, map, 640, 480);
  ASSERT_TRUE(same);
  EXPECT_THAT(same->missing, Contains(HasSubstr("only 1 views differ")));

  // Nothing in the right half of the image.
  auto left = DrawFrames(camera, map, draw);
  for (FrameMeasurements& frame : left) {
    auto& tags = frame.tags;
    tags.erase(std::remove_if(tags.begin(), tags.end(),
                              [](const TagDetection& tag) {
                                return std::any_of(tag.corners.begin(), tag.corners.end(),
                                                   [](const auto& c) { return c.x() > 300; });
                              }),
               tags.end());
  }
  const auto half = StartLens(left, map, 640, 480);
  ASSERT_TRUE(half);
  EXPECT_THAT(half->missing, Contains(HasSubstr("right")));
}

}  // namespace
}  // namespace tagtwist::internal::lens_test
