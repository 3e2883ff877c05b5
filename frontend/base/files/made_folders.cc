#include "frontend/base/files/made_folders.h"

#include <system_error>

namespace tagtwist::internal {

namespace fs = std::filesystem;

std::vector<std::string> MissingFolders(const std::string& folder) {
  std::vector<std::string> missing;
  std::error_code ignored;
  for (fs::path p = folder; !p.empty() && !fs::exists(p, ignored); p = p.parent_path()) {
    missing.insert(missing.begin(), p.string());
  }
  return missing;
}

void RemoveFolders(const std::vector<std::string>& outermost_first) {
  for (auto it = outermost_first.rbegin(); it != outermost_first.rend(); ++it) {
    ::rmdir(it->c_str());  // only while they are empty
  }
}

Status MakeFolders(const std::vector<std::string>& outermost_first) {
  for (size_t i = 0; i < outermost_first.size(); ++i) {
    std::error_code failure;
    fs::create_directory(outermost_first[i], failure);
    if (!failure) continue;
    RemoveFolders({outermost_first.begin(), outermost_first.begin() + static_cast<long>(i)});
    return Error{outermost_first[i] + ": cannot write: " + failure.message()};
  }
  return Ok();
}

}  // namespace tagtwist::internal
