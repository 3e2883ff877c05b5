#pragma once
#include <optional>

#include "frontend/base/fault.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Whether the images show tags, but not the map's: a few of the recording's first images are
/// searched for every family. A fault where another family has at least five times as many tags,
/// none of them with a bit mended, in most of the images; or where the map's family is there with
/// ids that the map lacks. `source`: opened anew, with images.
std::optional<Fault> FindOtherTags(DataSource* source, const TagMap& map);

}  // namespace tagtwist::internal
