#pragma once
#include <optional>
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/setup/yaml_value.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The section `tag_map` of a configuration that has no bodies: its tags, or the file it names.
/// `sigma_m`: of each coordinate of a tag's centre, where the section says it.
Result<TagMap> ReadMapSection(const YamlValue& node, const Limits& limits,
                              std::optional<double>* sigma_m);

/// What a map file of ours says of its tags; a pipe is not read again.
std::optional<double> SigmaOfMapFile(const std::string& path, const Limits& limits);

}  // namespace tagtwist::internal
