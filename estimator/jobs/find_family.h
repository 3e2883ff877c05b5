#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/fault.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Whether the images show tags, but not the map's: a few of the recording's first images are
/// searched for the families. A fault where another family has at least five times as many tags,
/// none of them with a bit mended, in most of the images; or where the map's family is there with
/// ids that the map lacks. `source`: opened anew, with images.
/// `families`: those that are looked for, TagFamilyNames() or some of them.
std::optional<Fault> FindOtherTags(DataSource* source, const TagMap& map,
                                   const std::vector<std::string>& families);

}  // namespace tagtwist::internal
