#pragma once
#include <string>
#include <utility>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/pose.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// A camera on the body.
struct RigCamera {
  std::string name = "cam0";
  Camera camera;
  double line_time_s = 0;  // of a rolling shutter: row v is taken line_time_s * v after the stamp
  Pose cam_from_body;
  double clock_offset_s = 0;  // its stamps plus this are times of the body's clock
};

/// The cameras of a body: one or several. What one camera must stand for all (tracks, guided
/// detection, calibration) is the first's.
struct Rig {
  std::vector<RigCamera> cameras = std::vector<RigCamera>(1);

  const RigCamera& front() const { return cameras.front(); }
  RigCamera& front() { return cameras.front(); }
  bool IsOfSeveral() const { return cameras.size() > 1; }
};

/// What is known of a recording before it is looked at: how the body sees, and where the tags are.
struct SetUp {
  Rig rig;
  TagMap map;
};

/// Of one camera, its shutter global.
inline SetUp MakeSetUp(const Camera& camera, const Pose& cam_from_body, TagMap map) {
  SetUp out;
  out.rig.front().camera = camera;
  out.rig.front().cam_from_body = cam_from_body;
  out.map = std::move(map);
  return out;
}

}  // namespace tagtwist
