#pragma once
#include "frontend/base/for_ranges.h"

namespace tagtwist::internal {

/// Spreads work over that many threads, the caller's among them, no more than the machine has. They
/// belong to what is returned and its copies, and end with the last of these; nothing of the
/// process changes. What `work` throws, the call throws.
ForRanges OnThreads(int threads);

}  // namespace tagtwist::internal
