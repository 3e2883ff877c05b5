#pragma once
#include <string>

#include "frontend/io/setup/yaml_reader.h"

namespace tagtwist {

/// True when the file begins like XML.
bool IsXml(const std::string& path);

/// OpenCV's XML storage (`<opencv_storage>`) as the tree that its YAML would give.
/// (cv::FileStorage itself reads outside of a file that is cut in the middle of an attribute.)
Result<YamlValue> ReadOpenCvXml(const std::string& path);

}  // namespace tagtwist
