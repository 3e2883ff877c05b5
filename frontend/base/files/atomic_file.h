#pragma once
#include <string>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Writes a file whole or not at all: into a temporary neighbour, renamed when all of it is on its
/// way to the disk. A device or pipe at `path` is written to directly, never replaced.
/// "out/states.csv: cannot write: No space left on device".
Status WriteFileAtomically(const std::string& path, const std::string& content);

}  // namespace tagtwist::internal
