#pragma once

namespace tagtwist {

/// What errors that last over a recording have in its states' sigmas: standard deviations, root
/// mean squares over states. All 0 where none was seen or looked for.
struct SystematicShare {
  double field_sigma_px = 0;  // what the lens model leaves, of a corner's coordinate
  double tag_sigma_m = 0;     // of each coordinate of a tag's position
  double bias_sigma_px = 0;   // of corners along their tags' diagonals
  double mount_sigma_rad = 0, mount_sigma_m = 0;          // of cameras after a rig's first
  double position_m = 0, rotation_rad = 0;                // 3-D norms, of a state
  double common_position_m = 0, common_rotation_rad = 0;  // the part that all states have in common
};

}  // namespace tagtwist
