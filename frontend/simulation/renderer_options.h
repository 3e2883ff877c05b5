#pragma once
#include <cstdint>
#include <optional>
#include <string>

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

struct RendererOptions {
  SceneOptions scene;
  int supersampling = 4;    // samples along a pixel's side, 1 to 16
  double blur_px = 0.5;     // Gaussian defocus, standard deviation, >= 0
  double vignetting = 0.2;  // share of light lost in the image's corners, 0 to 1
  double gradient = 0.2;    // illumination from one side of the image to the other, 0 to 1
  double gradient_direction_rad = 0;  // where it brightens: 0 to the right, pi/2 downwards
  double noise_grey = 2.0;            // sensor noise, standard deviation in grey levels, >= 0
  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("supersampling", self.supersampling);
    visit("blur_px", self.blur_px);
    visit("vignetting", self.vignetting);
    visit("gradient", self.gradient);
    visit("gradient_direction_rad", self.gradient_direction_rad);
    visit("noise_grey", self.noise_grey);
  }
};

}  // namespace tagtwist
