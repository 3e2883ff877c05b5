#pragma once
#include <functional>
#include <string>

#include "frontend/base/result.h"
#include "frontend/base/spans.h"

namespace tagtwist::internal {

/// What `run` returns, which tells what it is given of its stages; then `path` has them, however
/// that ended, as TraceRecorder::Json. An empty path: nullptr is given, and nothing written.
Status WithProfile(const std::string& path, const std::function<Status(SpanObserver*)>& run);

}  // namespace tagtwist::internal
