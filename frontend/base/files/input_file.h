#pragma once
#include <cstddef>
#include <cstdint>
#include <string>

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

/// Its first bytes, to tell kinds of files apart; none where it is not a regular file, of which
/// they would be missing later.
std::string FirstBytes(const std::string& path, size_t count);

/// Ok where `path` is a regular file, or is not there; else "x: expected a file, got a pipe".
Status CheckRegularFile(const std::string& path);

}  // namespace tagtwist::internal
