#pragma once
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A file's JSON, an object; an error names the file.
Result<nlohmann::ordered_json> ReadJsonObject(const std::string& path);

}  // namespace tagtwist::internal
