#pragma once
#include <optional>
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// A map's file, and what such files do not say.
struct TagMapFile {
  std::string path;
  std::optional<double> tag_size_m;  // side of the black square; needed for WPILib's
  std::string family;                // empty: the file's, or what its program prints
};

/// Reads a tag map (docs/formats.md), told apart by its content: Kalibr aprilgrid, WPILib field,
/// TagSLAM bodies, or the section `tag_map` of a configuration. Members that say nothing of the
/// tags are ignored. The map is checked (CheckTagMap).
Result<TagMap> ReadTagMapFile(const TagMapFile& file, const Limits& limits = {});

/// Beyond TagMap::Problem(): ids that the family lacks, tags that overlap. "tags 3 and 4 overlap".
std::optional<std::string> CheckTagMap(const TagMap& map);

}  // namespace tagtwist
