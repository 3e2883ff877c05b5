#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <tuple>

#include "frontend/simulation/renderer.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal::renderer_rays_test {
namespace {

// No blur, no noise, no shading, no scribble.
RendererOptions Plain() {
  RendererOptions out;
  out.blur_px = out.vignetting = out.gradient = out.noise_grey = 0;
  out.scene.scribbles_per_m2 = 0;
  return out;
}

Camera DistortedCamera() {
  Camera out;
  out.k1 = -0.28;
  out.k2 = 0.08;
  out.p1 = 1e-3;
  out.p2 = -5e-4;
  return out;
}

// A camera at a place that looks at another, rolled about its axis.
Pose LookAt(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double roll) {
  const Eigen::Vector3d forward = (to - from).normalized();
  const Eigen::Quaterniond turn =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), forward);
  return MakePose(turn * ExpSo3({0, 0, roll}), from);
}

bool IsOnFloor(const Tag& tag) {
  const auto corners = TagCornersInWorld(tag);
  return std::all_of(corners.begin(), corners.end(), [](const auto& c) { return c.z() == 0; });
}

// A ray caster that knows nothing of the renderer's ways: the grey that a ray sees, its nearest
// tag (with the white margin) or the floor.
double CastRay(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, const TagMap& map,
               const std::vector<TagPattern>& patterns, const SceneOptions& look) {
  double nearest = std::numeric_limits<double>::infinity(), grey = look.background_grey;
  if (direction.z() * origin.z() < 0) {
    nearest = -origin.z() / direction.z() * (1 + 1e-6);  // tags on the floor win
    grey = look.floor_grey;
  }
  // The sheets of tags that are each a plane of their own.
  for (const Tag& tag : map.tags()) {
    const Pose tag_from_world = Inverse(tag.world_from_tag);
    const Eigen::Vector3d o = tag_from_world * origin, d = tag_from_world.rotation() * direction;
    const double s = -o.z() / d.z() * (1 + 1e-6);
    if (!look.walls || IsOnFloor(tag) || !(s > 0) || !(s < nearest)) continue;
    if (!((o + s * d).head<2>().cwiseAbs().maxCoeff() < 1.5 * tag.size_m)) continue;
    nearest = s;
    grey = look.floor_grey;
  }
  for (size_t i = 0; i < map.tags().size(); ++i) {
    const Tag& tag = map.tags()[i];
    const Pose tag_from_world = Inverse(tag.world_from_tag);
    const Eigen::Vector3d o = tag_from_world * origin, d = tag_from_world.rotation() * direction;
    const double s = -o.z() / d.z();
    if (!(s > 0) || !(s < nearest)) continue;
    const TagPattern& pattern = patterns[i];
    const double cell = tag.size_m / pattern.square_cells;
    const int column =
        static_cast<int>(std::floor((o.x() + s * d.x()) / cell + 0.5 * pattern.cells));
    const int row = static_cast<int>(std::floor(0.5 * pattern.cells - (o.y() + s * d.y()) / cell));
    if (std::min(column, row) < 0 || std::max(column, row) >= pattern.cells) continue;
    nearest = s;
    const bool white = o.z() < 0 || pattern.IsWhite(column, row);  // the back is paper
    grey = white ? look.paper_grey : look.ink_grey;
  }
  return grey;
}

// Tags on the floor, on two walls, in front of one another, through one another, and one seen from
// its back.
TagMap RoomMap() {
  const Eigen::Quaterniond flat = Eigen::Quaterniond::Identity();
  const Eigen::Quaterniond wall_x(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitY()));
  const Eigen::Quaterniond wall_y(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  return TagMap("tag36h11",
                {{0, MakePose(flat, {0, 0, 0}), 0.15},
                 {1, MakePose(flat, {0.28, 0.02, 0}), 0.15},
                 {2, MakePose(wall_x, {-0.3, 0, 0.15}), 0.18},
                 {3, MakePose(wall_y, {0.05, 0.25, 0.12}), 0.18},
                 {4, MakePose(flat, {0.06, 0.07, 0.2}), 0.1},
                 {5, MakePose(flat * Eigen::Quaterniond(0, 1, 0, 0), {0.2, -0.2, 0.1}), 0.1},
                 {6, MakePose(ExpSo3({0.5, -0.6, 0.3}), {-0.1, -0.2, 0.05}), 0.12},
                 {7, MakePose(ExpSo3({0.6, 0, 0.2}), {0.28, 0.18, 0.12}), 0.12},
                 {8, MakePose(ExpSo3({-0.6, 0, 0.2}), {0.28, 0.18, 0.12}), 0.12}});
}

// With a distorting lens; with walls.
class RendererRays : public ::testing::TestWithParam<std::tuple<bool, bool>> {};

TEST_P(RendererRays, EveryPixelSeesWhatItsRaySees) {
  const auto [is_distorted, has_walls] = GetParam();
  const Camera camera = is_distorted ? DistortedCamera() : Camera();
  const TagMap map = RoomMap();
  RendererOptions options = Plain();
  options.scene.floor_grey = 160;
  options.scene.walls = has_walls;
  const auto renderer = Renderer::Make(camera, map, options);
  ASSERT_TRUE(renderer) << renderer.error().message;
  std::vector<int> ids;
  for (const Tag& tag : map.tags()) ids.push_back(tag.id);
  const auto patterns = MakeTagPatterns("tag36h11", ids);
  for (const Pose& world_from_cam :
       {LookAt({0.1, 0, 0.9}, {0.05, 0.02, 0}, 0.3), LookAt({0.5, -0.5, 0.45}, {0, 0, 0.05}, 2.0),
        LookAt({0.4, -0.25, 0.25}, {-0.1, 0.05, 0.1}, -0.4)}) {
    const cv::Mat image = renderer->Render({world_from_cam}, 0.0, 0);
    int compared = 0, dark = 0, wrong = 0;
    for (int v = 1; v < image.rows; v += 3) {
      for (int u = 1; u < image.cols; u += 3) {
        double least = 255, most = 0;
        for (const double du : {-0.8, 0.0, 0.8}) {
          for (const double dv : {-0.8, 0.0, 0.8}) {
            const auto ray = camera.Unproject({u + du, v + dv});
            ASSERT_TRUE(ray);
            const double grey = CastRay(world_from_cam.translation(),
                                        world_from_cam.rotation() * ray->homogeneous(), map,
                                        *patterns, options.scene);
            least = std::min(least, grey);
            most = std::max(most, grey);
          }
        }
        if (least != most) continue;  // an edge nearby
        ++compared;
        dark += least < 50;
        wrong += std::abs(image.at<uint8_t>(v, u) - least) > 1;
      }
    }
    EXPECT_GT(compared, 6000);
    EXPECT_GT(dark, 100);
    // Cells seen from their edge may be thinner than the 9 rays are apart.
    EXPECT_LT(wrong, compared / 500);
  }
}
INSTANTIATE_TEST_SUITE_P(Lens, RendererRays,
                         ::testing::Values(std::tuple(false, false), std::tuple(true, false),
                                           std::tuple(false, true)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param) ? "Distorted" : "Pinhole") +
                                  (std::get<1>(test.param) ? "Walls" : "");
                         });

}  // namespace
}  // namespace tagtwist::internal::renderer_rays_test
