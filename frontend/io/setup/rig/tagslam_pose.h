#pragma once
#include "frontend/io/setup/yaml_reader.h"
#include "frontend/io/setup/yaml_value.h"
#include "frontend/types/pose.h"

namespace tagtwist::internal {

/// TagSLAM's pose: `position` and a rotation vector, `rotation` or `rotvec`, of x, y, z each. Its
/// first fault is the parent's; of no node it is the identity.
Pose ReadTagSlamPose(const YamlValue* node, YamlSection* parent);

}  // namespace tagtwist::internal
