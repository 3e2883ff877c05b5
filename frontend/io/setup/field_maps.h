#pragma once
#include <optional>
#include <string>

#include "frontend/base/result.h"
#include "frontend/io/setup/yaml_reader.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Maps as other programs keep them; `family`: empty for what the file, or else its program, says.
/// WPILib's field (`tags` with ID and pose): x out of the tag's face, y to the right as printed, z
/// up. It does not tell the tags' size.
Result<TagMap> ReadWpilib(const YamlValue& root, std::optional<double> tag_size_m,
                          const std::string& family);
/// WPILib's field as CSV (ID,X,Y,Z,Z-Rotation,Y-Rotation): inches and degrees; the last is the turn
/// about the tag's own y axis after the one about z, under whichever name the seasons give it.
bool IsFieldCsv(const std::string& text);
Result<TagMap> ReadFieldCsv(std::string text, const std::string& path,
                            std::optional<double> tag_size_m, const std::string& family);
/// Limelight's field (`fiducials`): sizes in mm, tags turned as WPILib's.
Result<TagMap> ReadLimelight(const YamlValue& fiducials, const std::string& family);
/// The only bundle of apriltag_ros' tags.yaml (`tag_bundles`): tags as ours.
Result<TagMap> ReadBundle(const YamlValue& bundles, const std::string& family);

}  // namespace tagtwist::internal
