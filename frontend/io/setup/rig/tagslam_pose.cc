#include "frontend/io/setup/rig/tagslam_pose.h"

#include <Eigen/Core>
#include <string>

#include "frontend/io/setup/tag_map_reader.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {

Pose ReadTagSlamPose(const YamlValue* node, YamlSection* parent) {
  if (node == nullptr) return Pose();
  YamlSection section(*node);
  const Eigen::Vector3d position = ReadXyz(section.Require(std::string("position")), &section);
  const YamlValue* rotvec = section.Find("rotvec");
  const YamlValue* rotation = rotvec != nullptr ? rotvec : section.Require(std::string("rotation"));
  const Eigen::Vector3d vector = ReadXyz(rotation, &section);
  parent->Keep(section.FirstFault());
  return MakePose(ExpSo3(vector), position);
}

}  // namespace tagtwist::internal
