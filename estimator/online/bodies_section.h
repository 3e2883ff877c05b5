#pragma once
#include <optional>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/setup/yaml_value.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Whether a section `tag_map` has tags besides its bodies'; and without those.
bool HasOwnTags(const YamlValue& node);
YamlValue WithoutBodies(const YamlValue& node);
/// The bodies of a section that has any: a list, each with a name of its own and what
/// ReadMapSection reads; one family, and no id twice.
/// `sigma_m`: the largest that one of them says of its tags.
Result<std::vector<TaggedBody>> ReadBodies(const YamlValue& node, const Limits& limits,
                                           std::optional<double>* sigma_m);

/// Whether they are of the map's family and have none of its ids.
Status CheckOnce(const YamlValue& node, const TagMap& map, const std::vector<TaggedBody>& bodies);

}  // namespace tagtwist::internal
