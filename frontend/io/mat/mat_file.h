#pragma once
#include <memory>
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/mat/mat_contents.h"

namespace tagtwist::internal {

/// True when the head of the file says MATLAB 5 or 7.3.
bool IsMatFile(const std::string& path);

/// Refuses what is not whole: "x.mat: truncated: ...", "x.mat: damaged: ...".
Result<std::unique_ptr<MatFile>> OpenMatFile(const std::string& path, const Limits& limits = {});

}  // namespace tagtwist::internal
