#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/tag_family.h"

namespace tagtwist {

/// What the camera can see besides the tags. Greys are 0..255 as a perfect camera would give them.
struct SceneOptions {
  uint64_t random_seed = 1;
  bool floor = true;             // the plane z = 0
  bool walls = false;            // sheets behind the tags that are not on the floor
  double paper_grey = 225;       // white cells and tag margins
  double ink_grey = 25;          // black cells
  double floor_grey = 225;       // the plane z = 0, and the walls
  double background_grey = 110;  // where there is no floor
  double scribbles_per_m2 = 90;  // polylines and blobs on floor and walls, never on a paper
  int occluders = 0;             // dark or bright ellipses over the map
  double occluder_radius_m = 0.08;
  double occluder_height_m = 0.3;  // they float between the floor and this height
  double occluder_speed_mps = 0;   // largest speed of an occluder; 0: they stand still
  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("random_seed", self.random_seed);
    visit("floor", self.floor);
    visit("walls", self.walls);
    visit("paper_grey", self.paper_grey);
    visit("ink_grey", self.ink_grey);
    visit("floor_grey", self.floor_grey);
    visit("background_grey", self.background_grey);
    visit("scribbles_per_m2", self.scribbles_per_m2);
    visit("occluders", self.occluders);
    visit("occluder_radius_m", self.occluder_radius_m);
    visit("occluder_height_m", self.occluder_height_m);
    visit("occluder_speed_mps", self.occluder_speed_mps);
  }
};

/// A flat patch: the points centre + u half_u + v half_v with |u|, |v| <= 1 (rectangle) or
/// u^2 + v^2 <= 1 (ellipse), in W [m].
struct Patch {
  enum class Shape { kRectangle, kEllipse };
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  Eigen::Vector3d half_u = Eigen::Vector3d::UnitX(), half_v = Eigen::Vector3d::UnitY();
  Shape shape = Shape::kRectangle;
  double grey = 0;                      // of a plain patch
  const TagPattern* pattern = nullptr;  // of a tag: u to the right, v up as printed
};

/// What carries tags that are not on the floor, a rectangle, and what is drawn on it.
struct WallSheet {
  Patch sheet;
  std::vector<Patch> scribbles;
};

/// True when the patch hides the point from the camera's centre.
bool Hides(const Patch& patch, const Eigen::Vector3d& camera_in_world,
           const Eigen::Vector3d& point_in_world);

}  // namespace tagtwist
