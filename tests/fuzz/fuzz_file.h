#pragma once
#include <string>
#include <utility>
#include <vector>

#include "tests/support/temp_folder.h"
#include "tests/support/test_files.h"

namespace tagtwist::internal {

/// Bytes as a file, as long as this lives.
class FuzzFile {
 public:
  explicit FuzzFile(const std::string& bytes) { WriteText(path(), bytes); }
  std::string path() const { return folder_ / "x"; }

 private:
  TempFolder folder_;
};

/// A folder's files as one text: a line "=== name" before each.
using FuzzTree = std::vector<std::pair<std::string, std::string>>;
std::string PackTree(const FuzzTree& tree);
/// Names that lead out of the folder are left out.
FuzzTree UnpackTree(const std::string& bytes);
FuzzTree ReadTree(const std::string& folder);
void WriteTree(const FuzzTree& tree, const std::string& folder);

}  // namespace tagtwist::internal
