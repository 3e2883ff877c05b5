// Corners of a sheet as drawn cameras see them, and what is expected of the lens that is found.
#pragma once
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <utility>
#include <vector>

#include "estimator/calibration/lens/lens_from_nothing.h"
#include "estimator/report/files/camera_found.h"
#include "frontend/types/tag_map.h"
#include "residuals/lens.h"
#include "tests/support/draws.h"

namespace tagtwist::internal::drawn_views {

inline TagMap Sheet() {
  TagGrid grid;
  grid.rows = grid.columns = 6;
  grid.tag_size_m = 0.03;
  grid.row_gaps_m = grid.column_gaps_m = std::vector<double>(5, 0.01);
  return MakeTagMap(grid);
}

inline Camera CameraOf(double focal_px, LensModel lens) {
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
inline FrameMeasurements See(const Camera& camera, const TagMap& map, const Pose& cam_from_world,
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
      seen.corners[c] = pixel + DrawVector<2>(noise, *engine);
    }
    if (is_whole) out.tags.push_back(seen);
  }
  return out;
}

// Looks at a place of the sheet from so near that about all of it fills the image.
inline Pose DrawView(const Camera& camera, const Draw& draw, std::mt19937* engine) {
  std::uniform_real_distribution<double> unit(-1, 1);
  const Eigen::Vector2d off = DrawVector<2>(unit, *engine);
  const Eigen::Vector3d middle(0.115 + 0.1 * off.x(), 0.115 + 0.1 * off.y(), 0);
  const double half_rad = std::min(1.2, std::atan(0.5 * camera.width / camera.fx));
  const double distance_m = (1.1 + 0.3 * unit(*engine)) * 0.13 / std::tan(half_rad);
  // z of the sheet is up: the camera looks down on it, turned about its axis and tilted.
  const Eigen::Vector3d turn = DrawVector<3>(unit, *engine);
  const Eigen::Quaterniond attitude =
      Eigen::AngleAxisd(draw.tilt_rad * turn.x(), Eigen::Vector3d::UnitX()) *
      Eigen::AngleAxisd(draw.tilt_rad * turn.y(), Eigen::Vector3d::UnitY()) *
      Eigen::AngleAxisd(3 * turn.z(), Eigen::Vector3d::UnitZ()) * Eigen::Quaterniond(0, 1, 0, 0);
  return MakePose(attitude, Eigen::Vector3d(0, 0, distance_m) - attitude * middle);
}

inline std::vector<FrameMeasurements> DrawFrames(const Camera& camera, const TagMap& map,
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

struct Case {
  const char* name;
  double focal_px;
  LensModel lens;
  double k1, k2;
};
inline Camera TruthOf(const Case& of) {
  Camera out = CameraOf(of.focal_px, of.lens);
  out.k1 = of.k1, out.k2 = of.k2;
  return out;
}
// Number of entries more than 3 sigmas off, and all of them.
inline std::pair<int, int> Outside(const LensFound& found, const Camera& truth) {
  const Eigen::VectorXd error = LensDifference(found.calibration.set_up.rig.front().camera, truth);
  std::pair<int, int> out;
  for (int i = 0; i < static_cast<int>(error.size()); ++i) {
    if (!found.calibration.applied[static_cast<size_t>(i)]) continue;
    ++out.second;
    out.first += std::abs(error(i)) > 3 * found.inflation() * found.calibration.sigma(i) ? 1 : 0;
  }
  return out;
}

// Adds to the entries that are more than 3 sigmas off, and to all.
inline void ExpectGood(const LensFound& found, const Camera& truth, std::pair<int, int>* outside) {
  const Camera& camera = found.calibration.set_up.rig.front().camera;
  EXPECT_EQ(camera.lens, truth.lens) << ToString(found.kind);
  EXPECT_EQ(CameraVerdict(found), "good: nothing speaks against it");
  EXPECT_NEAR(camera.fx / truth.fx, 1, 0.002);
  EXPECT_LT(found.inflation() * found.calibration.sigma(kLogFocal), 0.002);
  const auto [out, of] = Outside(found, truth);
  outside->first += out, outside->second += of;
}

}  // namespace tagtwist::internal::drawn_views
