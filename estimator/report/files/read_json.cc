#include "estimator/report/files/read_json.h"

#include <cstdint>
#include <nlohmann/json.hpp>

#include "frontend/base/files/input_file.h"

namespace tagtwist::internal {

Result<nlohmann::ordered_json> ReadJsonObject(const std::string& path) {
  constexpr int64_t kMostBytes = 1LL << 30;
  const auto text = ReadWholeFile(path, kMostBytes);
  if (!text) return text.error();
  auto json = nlohmann::ordered_json::parse(*text, nullptr, /*allow_exceptions=*/false);
  if (json.is_object()) return json;
  return Error{path + ": expected JSON, an object: it is cut, or of something else"};
}

}  // namespace tagtwist::internal
