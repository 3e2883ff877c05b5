#pragma once
#include <string>

#include "frontend/base/limits.h"
#include "frontend/io/setup/yaml_value.h"

namespace tagtwist::internal {

/// True when the text begins like XML.
bool LooksLikeXml(const std::string& text);

/// OpenCV's XML storage (`<opencv_storage>`) as the tree that its YAML would give.
/// At most 200,000 nodes and 64 MB of names and texts; `file` is for messages.
/// (cv::FileStorage itself reads outside of a file that is cut in the middle of an attribute.)
Result<YamlValue> ParseOpenCvXml(const std::string& text, const std::string& file,
                                 const Limits& limits = {});

}  // namespace tagtwist::internal
