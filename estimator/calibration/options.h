#pragma once
#include <optional>
#include <string>

namespace tagtwist {

/// How far the configured set-up may be from the truth: standard deviations of the priors. 0 holds
/// a parameter where it is. Field names are the YAML keys of the section `calibration`.
struct CalibrationOptions {
  double focal_sigma = 0.02;             // of the focal length, relative
  double aspect_sigma = 0.002;           // of fy / fx
  double principal_point_sigma = 0.015;  // of each coordinate, in image widths
  double radial_sigma = 0.05;            // of k1 and k2
  double tangential_sigma = 0.005;       // of p1 and p2
  double higher_distortion_sigma = 0;    // of every further coefficient
  double line_time_sigma_s = 0;          // of a rolling shutter's time from row to row
  double print_scale_sigma = 0.005;      // of the whole map, relative
  double tag_position_sigma_m = 0.01;    // of each coordinate of a tag's centre
  double tag_rotation_sigma_rad = 0.03;  // of a tag about each axis
  double tag_bend_sigma = 0.007;         // of a tag's bend (Tag::bend_m), in its sides
  double mount_position_sigma_m = 0.03;  // of cam_from_body; these four against ground truth only
  double mount_rotation_sigma_rad = 0.03;
  double world_position_sigma_m = 0.03;  // of the map in the ground truth's world
  double world_rotation_sigma_rad = 0.03;
  double time_offset_sigma_s = 0.02;  // of the ground truth's clock
  int validation_blocks = 20;         // stretches fitted and judged in turn, >= 4

  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("focal_sigma", self.focal_sigma);
    visit("aspect_sigma", self.aspect_sigma);
    visit("principal_point_sigma", self.principal_point_sigma);
    visit("radial_sigma", self.radial_sigma);
    visit("tangential_sigma", self.tangential_sigma);
    visit("higher_distortion_sigma", self.higher_distortion_sigma);
    visit("line_time_sigma_s", self.line_time_sigma_s);
    visit("print_scale_sigma", self.print_scale_sigma);
    visit("tag_position_sigma_m", self.tag_position_sigma_m);
    visit("tag_rotation_sigma_rad", self.tag_rotation_sigma_rad);
    visit("tag_bend_sigma", self.tag_bend_sigma);
    visit("mount_position_sigma_m", self.mount_position_sigma_m);
    visit("mount_rotation_sigma_rad", self.mount_rotation_sigma_rad);
    visit("world_position_sigma_m", self.world_position_sigma_m);
    visit("world_rotation_sigma_rad", self.world_rotation_sigma_rad);
    visit("time_offset_sigma_s", self.time_offset_sigma_s);
    visit("validation_blocks", self.validation_blocks);
  }
};

}  // namespace tagtwist
