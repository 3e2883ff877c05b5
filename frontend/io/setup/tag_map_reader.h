#pragma once
#include "frontend/io/setup/yaml_reader.h"
#include "frontend/types/pose.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The section `tag_map` of a configuration: either `grid` or `tags` (docs/formats.md).
Result<TagMap> ReadTagMap(const YamlValue& section);

/// A rotation from the member `rotation` (nine numbers, row by row) or `quaternion_xyzw` of a
/// section; nullopt when it has neither. Faults are kept in the section.
std::optional<Eigen::Quaterniond> ReadRotation(YamlSection* section);
/// Three numbers, or nullopt with the fault kept in the section.
std::optional<Eigen::Vector3d> ReadVector3(const YamlValue* node, YamlSection* section);
/// The members x, y and z of a mapping; of no node, or with a fault, which its parent keeps, zeros.
Eigen::Vector3d ReadXyz(const YamlValue* node, YamlSection* parent);

}  // namespace tagtwist::internal
