#pragma once
#include <string>

#include "frontend/base/limits.h"
#include "frontend/io/setup/yaml_value.h"

namespace tagtwist::internal {

/// The tree of a text's single YAML document; `file` is for messages. OpenCV's first line,
/// %YAML:1.0, counts as a comment; an empty document after it (a closing ---) does not count. An
/// alias is copied, and counts as all that it stands for. Refused, besides what is not YAML: a key
/// given twice in one mapping, an alias of what it is in, more levels, nodes or bytes of names and
/// texts than the limits have. Takes time and memory in proportion to the text and those bounds,
/// whatever it says.
Result<YamlValue> ParseYaml(std::string text, const std::string& file, const Limits& limits = {});

}  // namespace tagtwist::internal
