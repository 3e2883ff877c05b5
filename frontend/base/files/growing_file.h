#pragma once
#include <string>
#include <string_view>
#include <utility>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A file that is written piece by piece and holds few of them in memory.
class GrowingFile {
 public:
  /// A new file, which must not be there. "x.csv: cannot write: File exists".
  static Result<GrowingFile> Make(const std::string& path);
  GrowingFile(GrowingFile&& other) noexcept;
  GrowingFile& operator=(GrowingFile&& other) noexcept;
  GrowingFile(const GrowingFile&) = delete;
  GrowingFile& operator=(const GrowingFile&) = delete;
  ~GrowingFile();

  Status Append(std::string_view text);
  /// Writes what waits; nothing may be added any more.
  Status Close();

 private:
  GrowingFile(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  Status Write();

  std::string path_, waiting_;
  int descriptor_ = -1;
};

}  // namespace tagtwist::internal
