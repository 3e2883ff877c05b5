#pragma once
#include <unistd.h>

#include <filesystem>
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Folders that must be made for `folder` to be there, outermost first.
std::vector<std::string> MissingFolders(const std::string& folder);

/// Makes the folders; those that were made are gone again after an error.
Status MakeFolders(const std::vector<std::string>& outermost_first);

/// Removes them as far as they are empty. Asks for no memory.
void RemoveFolders(const std::vector<std::string>& outermost_first);

/// A run that begins beside this one makes folders that both need, and takes them away again when
/// it has seen that it can: an attempt that failed is made again as long as the folder is not
/// there.
template <typename Attempt>
auto WhileFoldersComeAndGo(const std::string& folder, const Attempt& attempt) {
  constexpr int kMostAttempts = 50;
  auto out = attempt();
  std::error_code ignored;
  for (int i = 1; i < kMostAttempts && !out && !std::filesystem::exists(folder, ignored); ++i) {
    ::usleep(200);
    out = attempt();
  }
  return out;
}

}  // namespace tagtwist::internal
