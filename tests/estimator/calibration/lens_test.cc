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

namespace tagtwist::internal::lens_test {
namespace {

using ::testing::Contains;
using ::testing::HasSubstr;

TagMap Sheet() {
  TagGrid grid;
  grid.rows = grid.columns = 6;
  grid.tag_size_m = 0.03;
  grid.row_gaps_m = grid.column_gaps_m = std::vector<double>(5, 0.01);
  return MakeTagMap(grid);
}

Camera CameraOf(double focal_px, LensModel lens) {
  Camera camera;
  camera.width = 640, camera.height = 480;
  camera.fx = focal_px, camera.fy = 1.002 * focal_px;
  camera.cx = 325.4, camera.cy = 236.1;
  camera.lens = lens;
  return camera;
}

struct Draw {
  double tilt_rad = 0.7;  // of the sheet about each of its axes
  int views = 40;
  bool pairs = false;  // each with a frame 30 ms later, the camera in motion
  double line_time_s = 0;
  double corner_sigma_px = 0.1;
  unsigned seed = 1;
};

// The corners that the camera sees from there, row v line_time * v later.
FrameMeasurements See(const Camera& camera, const TagMap& map, const Pose& cam_from_world,
                      const PoseStep& motion, const Draw& draw, std::mt19937* engine) {
  std::normal_distribution<double> noise(0, draw.corner_sigma_px);
  FrameMeasurements out;
  for (const Tag& tag : map.tags()) {
    TagDetection seen;
    seen.id = tag.id;
    bool is_whole = true;
    for (size_t c = 0; c < 4 && is_whole; ++c) {
      const Eigen::Vector3d corner = map.CornersInWorld(tag.id)[c];
      Eigen::Vector2d pixel(0, 0);
      for (int pass = 0; pass < 4 && is_whole; ++pass) {
        const PoseStep way = draw.line_time_s * pixel.y() * motion;
        is_whole = camera.Project(Retract(cam_from_world, way) * corner, &pixel);
      }
      is_whole = is_whole && camera.Contains(pixel);
      seen.corners[c] = pixel + Eigen::Vector2d(noise(*engine), noise(*engine));
    }
    if (is_whole) out.tags.push_back(seen);
  }
  return out;
}

// Looks at a place of the sheet from so near that about all of it fills the image.
Pose DrawView(const Camera& camera, const Draw& draw, std::mt19937* engine) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Eigen::Vector3d middle(0.115 + 0.1 * unit(*engine), 0.115 + 0.1 * unit(*engine), 0);
  const double half_rad = std::min(1.2, std::atan(0.5 * camera.width / camera.fx));
  const double distance_m = (1.1 + 0.3 * unit(*engine)) * 0.13 / std::tan(half_rad);
  // z of the sheet is up: the camera looks down on it, turned about its axis and tilted.
  const Eigen::Quaterniond attitude =
      Eigen::AngleAxisd(draw.tilt_rad * unit(*engine), Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(draw.tilt_rad * unit(*engine), Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(3 * unit(*engine), Eigen::Vector3d::UnitZ()) *
      Eigen::Quaterniond(0, 1, 0, 0);
  return MakePose(attitude, Eigen::Vector3d(0, 0, distance_m) - attitude * middle);
}

std::vector<FrameMeasurements> DrawFrames(const Camera& camera, const TagMap& map,
                                          const Draw& draw) {
  std::mt19937 engine(draw.seed);
  std::normal_distribution<double> normal;
  std::vector<FrameMeasurements> out;
  for (int i = 0; i < draw.views; ++i) {
    const Pose pose = DrawView(camera, draw, &engine);
    PoseStep motion = PoseStep::Zero();
    for (double& entry : motion) entry = draw.pairs ? 0.4 * normal(engine) : 0;
    motion.tail<3>() *= 0.3;
    for (int k = 0; k < (draw.pairs ? 2 : 1); ++k) {
      const Pose at = Retract(pose, PoseStep(0.03 * k * motion));
      out.push_back(See(camera, map, at, motion, draw, &engine));
      out.back().t_ns = 1000000000LL * i + 30000000LL * k;
    }
  }
  return out;
}

Result<LensFound> Find(const std::vector<FrameMeasurements>& frames, const TagMap& map) {
  const auto starts = StartLens(frames, map, 640, 480);
  if (!starts) return starts.error();
  return FindLens(frames, map, *starts);
}

// Number of entries more than 3 sigmas off, and all of them.
std::pair<int, int> Outside(const LensFound& found, const Camera& truth) {
  const Eigen::VectorXd error = LensDifference(found.calibration.set_up.rig.front().camera, truth);
  std::pair<int, int> out;
  for (int i = 0; i < static_cast<int>(error.size()); ++i) {
    if (!found.calibration.applied[static_cast<size_t>(i)]) continue;
    ++out.second;
    out.first += std::abs(error(i)) > 3 * found.inflation() * found.calibration.sigma(i) ? 1 : 0;
  }
  return out;
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

struct Case {
  const char* name;
  double focal_px;
  LensModel lens;
  double k1, k2;
};
class LensFromNothing : public testing::TestWithParam<Case> {};

TEST_P(LensFromNothing, IsTheTruthWithinItsSigmas) {
  const TagMap map = Sheet();
  Camera truth = CameraOf(GetParam().focal_px, GetParam().lens);
  truth.k1 = GetParam().k1, truth.k2 = GetParam().k2;
  int outside = 0, all = 0;
  for (const unsigned seed : {1U, 2U}) {
    Draw draw;
    draw.seed = seed;
    const auto found = Find(DrawFrames(truth, map, draw), map);
    ASSERT_TRUE(found) << found.error().message;
    const Camera& camera = found->calibration.set_up.rig.front().camera;
    EXPECT_EQ(camera.lens, truth.lens) << ToString(found->kind);
    EXPECT_EQ(CameraVerdict(*found), "good: nothing speaks against it");
    EXPECT_NEAR(camera.fx / truth.fx, 1, 0.002);
    EXPECT_LT(found->inflation() * found->calibration.sigma(kLogFocal), 0.002);
    const auto [out, of] = Outside(*found, truth);
    outside += out, all += of;
  }
  EXPECT_GE(all, 8);
  EXPECT_LE(outside, 1) << "of " << all;
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
