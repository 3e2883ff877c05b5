#pragma once
#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "frontend/base/files/descriptor.h"
#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// All bytes of a file, at most `most` of them: limits.file_bytes where it is left out, and
/// limits.text_bytes for what becomes a tree. A pipe is read once, in order, as far as
/// limits.pipe_bytes; one that nobody writes into is refused, as are folders and devices.
/// "x.csv: cannot open: No such file or directory", "x.csv: is larger than 20 MB".
Result<std::string> ReadWholeFile(const std::string& path, int64_t most, const Limits& limits = {});
Result<std::string> ReadWholeFile(const std::string& path, const Limits& limits = {});
Result<std::string> ReadTextFile(const std::string& path, const Limits& limits = {});

/// A file whose bytes come a piece at a time, in order, as often as one likes: nothing of it is
/// kept, but a pipe, which is read once, whole. Faults are those of ReadWholeFile.
class PiecewiseFile {
 public:
  static Result<PiecewiseFile> Open(const std::string& path, const Limits& limits = {});
  /// Appends the next bytes to `out`, at most 64 KiB, and says whether there were any. Once its end
  /// was met, the file is as long as it was then: what is added later is not read, and what was
  /// taken away is an error.
  Result<bool> AppendTo(std::string* out);
  /// From its first byte again.
  void Rewind() { offset_ = 0; }

 private:
  PiecewiseFile(const std::string& path, int64_t most)
      : path_(path), most_(most), file_(std::make_unique<Descriptor>(path)) {}
  ssize_t ReadAt(int64_t offset, char* to, size_t most) const;

  std::string path_;
  int64_t most_;
  std::unique_ptr<Descriptor> file_;
  std::optional<std::string> of_pipe_;
  int64_t offset_ = 0;
  std::optional<int64_t> size_;
};

/// Its first bytes, to tell kinds of files apart; none where it is not a regular file, of which
/// they would be missing later.
std::string FirstBytes(const std::string& path, size_t count);

/// Ok where `path` is a regular file, or is not there; else "x: expected a file, got a pipe".
Status CheckRegularFile(const std::string& path);

}  // namespace tagtwist::internal
