#pragma once
#include <cstddef>

#include "tests/support/sanitizers.h"

namespace tagtwist::internal {

/// What a program whose malloc is that of counted_heap.cc has allocated.
struct HeapCount {
  size_t allocations = 0;  // since it began
  size_t bytes = 0;        // that are not freed, with what malloc rounds them up by
  size_t peak_bytes = 0;   // the most of these since ForgetHeapPeak
};
HeapCount HeapSoFar();
void ForgetHeapPeak();

/// Nothing is counted under the sanitizers.
#ifdef TAGTWIST_SANITIZED
inline constexpr bool kHeapIsCounted = false;
#else
inline constexpr bool kHeapIsCounted = true;
#endif

}  // namespace tagtwist::internal
