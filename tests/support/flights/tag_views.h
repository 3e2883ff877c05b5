#pragma once
#include <algorithm>
#include <random>
#include <vector>

#include "tests/support/draws.h"
#include "tests/support/flights/tag_scene.h"

namespace tagtwist::internal {

/// Where tags hang in a scene that is drawn.
enum class TagPlaces { kOne, kRow, kFloor, kWall, kCeiling, kRoom };

/// A map, and its tags as a camera sees them that is carried about in front of it.
struct TagViews {
  TagMap map;
  Camera camera;
  std::vector<std::vector<TagDetection>> frames;
};

namespace tag_views {

inline Tag TagAt(int id, double size_m, const Eigen::Quaterniond& rotation,
                 const Eigen::Vector3d& position) {
  Tag tag;
  tag.id = id;
  tag.world_from_tag = MakePose(rotation, position);
  tag.size_m = size_m;
  return tag;
}

// Tags of 0.15 m, upright or turned by quarters, in a plane whose normal is z before it is turned.
inline std::vector<Tag> Sheet(const Eigen::Quaterniond& world_from_sheet, const Eigen::Vector3d& at,
                              int columns, int rows, int first_id, std::mt19937_64* engine) {
  std::uniform_real_distribution<double> gap(0.3, 0.45);
  const double dx = gap(*engine), dy = gap(*engine);
  std::vector<Tag> out;
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const Eigen::Vector3d place((column - 0.5 * (columns - 1)) * dx,
                                  (row - 0.5 * (rows - 1)) * dy, 0);
      out.push_back(TagAt(first_id++, 0.15, world_from_sheet, at + world_from_sheet * place));
    }
  }
  return out;
}

inline std::vector<Tag> TagsOf(TagPlaces places, std::mt19937_64* engine) {
  const Eigen::Quaterniond up = Eigen::Quaterniond::Identity();
  const Eigen::Quaterniond wall(Eigen::AngleAxisd(M_PI / 2, Eigen::Vector3d::UnitX()));
  const Eigen::Quaterniond ceiling(Eigen::AngleAxisd(M_PI, Eigen::Vector3d::UnitX()));
  const Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  if (places == TagPlaces::kOne) return Sheet(up, origin, 1, 1, 0, engine);
  if (places == TagPlaces::kRow) return Sheet(up, origin, 5, 1, 0, engine);
  if (places == TagPlaces::kFloor) return Sheet(up, origin, 5, 5, 0, engine);
  if (places == TagPlaces::kWall) return Sheet(wall, origin, 5, 4, 0, engine);
  if (places == TagPlaces::kCeiling) return Sheet(ceiling, {0, 0, 2.5}, 5, 5, 0, engine);
  std::vector<Tag> out = Sheet(up, {0, -0.6, 0}, 4, 3, 0, engine);
  const std::vector<Tag> on_wall = Sheet(wall, {0, 0.2, 0.6}, 4, 3, 12, engine);
  out.insert(out.end(), on_wall.begin(), on_wall.end());
  return out;
}

// Looks at a point near a tag, from its front, at up to 50 degrees from its normal.
inline Pose CamFromWorld(const Tag& tag, const Eigen::Vector4d& way, double roll_rad) {
  const Eigen::Matrix3d axes = tag.world_from_tag.rotation().toRotationMatrix();
  const Eigen::Vector3d target = tag.world_from_tag.translation();
  const Eigen::Vector3d from = Eigen::Vector3d(way[0], way[1], 1).normalized() * way[2];
  const Eigen::Vector3d eye = target + axes * from;
  const Eigen::Vector3d forward = (target - eye).normalized();
  const Eigen::Vector3d right =
      (std::cos(roll_rad) * axes.col(0) + std::sin(roll_rad) * axes.col(1)).cross(forward);
  Eigen::Matrix3d cam_from_world;
  cam_from_world.row(0) = right.normalized();
  cam_from_world.row(1) = forward.cross(right.normalized());
  cam_from_world.row(2) = forward;
  return MakePose(Eigen::Quaterniond(cam_from_world), -(cam_from_world * eye));
}

}  // namespace tag_views

/// 60 frames with corner noise of noise_px; a camera of 640 x 480.
inline TagViews DrawViews(TagPlaces places, unsigned seed, double noise_px = 0.2) {
  std::mt19937_64 engine(seed);
  std::uniform_real_distribution<double> unit(-1, 1);
  TagViews out;
  const std::vector<Tag> tags = tag_views::TagsOf(places, &engine);
  out.map = TagMap("tag36h11", tags);
  out.camera.width = 640;
  out.camera.height = 480;
  out.camera.fx = out.camera.fy = 500;
  out.camera.cx = 319.5;
  out.camera.cy = 239.5;
  const Tag& target = tags[tags.size() / 2];
  const Eigen::Vector3d from = DrawVector<3>(unit, engine);
  const Eigen::Vector4d way(from.x(), from.y(), 1.4 + 0.5 * from.z(), 0);
  const double roll = M_PI * unit(engine);
  const Eigen::Vector3d by = DrawVector<3>(unit, engine);
  const Eigen::Vector4d step(0.01 * by.x(), 0.01 * by.y(), 0.003 * by.z(), 0);
  for (unsigned k = 0; k < 60; ++k) {
    const Pose cam_from_world = tag_views::CamFromWorld(target, way + k * step, roll + 0.01 * k);
    // Those that show their backs are not seen.
    std::vector<TagDetection> seen =
        SeeTags(out.map, out.camera, cam_from_world, noise_px, 1000 * seed + k);
    seen.erase(std::remove_if(seen.begin(), seen.end(),
                              [&](const TagDetection& tag) {
                                const Pose cam_from_tag =
                                    cam_from_world * out.map.Find(tag.id)->world_from_tag;
                                const Eigen::Vector3d normal =
                                    cam_from_tag.rotation() * Eigen::Vector3d::UnitZ();
                                const Eigen::Vector3d sight =
                                    cam_from_tag.translation().normalized();
                                return normal.dot(sight) > -0.15;
                              }),
               seen.end());
    out.frames.push_back(std::move(seen));
  }
  return out;
}

/// A random quad with the id of one of the map's tags.
inline TagDetection DrawPhantom(const TagViews& views, std::mt19937_64* engine) {
  std::uniform_real_distribution<double> x(5, 635), y(5, 475), off(-60, 60);
  std::uniform_int_distribution<size_t> which(0, views.map.tags().size() - 1);
  TagDetection out;
  out.id = views.map.tags()[which(*engine)].id;
  const double at_y = y(*engine), at_x = x(*engine);
  const Eigen::Vector2d at(at_x, at_y);
  for (auto& corner : out.corners) corner = at + DrawVector<2>(off, *engine);
  return out;
}

}  // namespace tagtwist::internal
