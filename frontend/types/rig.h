#pragma once
#include <Eigen/Core>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "frontend/base/named_enum.h"
#include "frontend/types/camera.h"
#include "frontend/types/pose.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// What a camera is fixed to.
enum class MountedOn {
  kBody,   // it moves with the body, and the map's tags stand in W
  kWorld,  // it stands in W, and the map's tags are on the body: what the map calls W is B
};

template <>
struct EnumNames<MountedOn> {
  static constexpr std::array<std::pair<MountedOn, const char*>, 2> kAll = {
      {{MountedOn::kBody, "body"}, {MountedOn::kWorld, "world"}}};
};

/// A camera on the body, or one that watches it.
struct RigCamera {
  std::string name = "cam0";
  Camera camera;
  double line_time_s = 0;  // of a rolling shutter: row v is taken line_time_s * v after the stamp
  Pose cam_from_body;      // of one that stands in W: cam_from_world
  double clock_offset_s = 0;  // its stamps plus this are times of the body's clock
  /// What is known of its errors: covariance of [log focal length (both), log fy/fx, cx [px],
  /// cy [px], distortion coefficients in the order of the configuration, step of cam_from_body (6,
  /// Retract)]. Of size 0 where nothing is said.
  Eigen::MatrixXd covariance = {};
};

/// The cameras of a body, or those that watch it: one or several. What is of one camera alone
/// (a device's images, the calibration of lens and map) is the first's.
struct Rig {
  std::vector<RigCamera> cameras = std::vector<RigCamera>(1);
  MountedOn mounted_on = MountedOn::kBody;  // all of them

  const RigCamera& front() const { return cameras.front(); }
  RigCamera& front() { return cameras.front(); }
  bool IsOfSeveral() const { return cameras.size() > 1; }
  /// Whether it is what everything works with: one camera, which the body carries.
  bool IsOneOnTheBody() const { return !IsOfSeveral() && mounted_on == MountedOn::kBody; }
};

/// What is known of a recording before it is looked at: how the body sees or is seen, and where
/// the tags are.
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
