#include "tests/support/counted_heap.h"

#include <malloc.h>

#include <atomic>
#include <cerrno>

namespace tagtwist::internal {
namespace {

std::atomic<size_t> g_allocations{0}, g_bytes{0}, g_peak{0};

}  // namespace

HeapCount HeapSoFar() { return {g_allocations.load(), g_bytes.load(), g_peak.load()}; }

void ForgetHeapPeak() { g_peak = g_bytes.load(); }

#ifndef TAGTWIST_SANITIZED
namespace {

void* Counted(void* memory) {
  g_allocations.fetch_add(1, std::memory_order_relaxed);
  const size_t size = malloc_usable_size(memory);
  const size_t bytes = g_bytes.fetch_add(size, std::memory_order_relaxed) + size;
  size_t peak = g_peak.load(std::memory_order_relaxed);
  while (peak < bytes && !g_peak.compare_exchange_weak(peak, bytes, std::memory_order_relaxed)) {
  }
  return memory;
}

void Forget(void* memory) {
  g_bytes.fetch_sub(malloc_usable_size(memory), std::memory_order_relaxed);
}

}  // namespace
#endif

}  // namespace tagtwist::internal

#ifndef TAGTWIST_SANITIZED
// NOLINTBEGIN(readability-identifier-naming): the C library's names; operator new and Eigen call
// these.
using tagtwist::internal::Counted;
using tagtwist::internal::Forget;

extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* memory, size_t size);
void* __libc_memalign(size_t alignment, size_t size);
void __libc_free(void* memory);

void* malloc(size_t size) noexcept { return Counted(__libc_malloc(size)); }
void* calloc(size_t count, size_t size) noexcept { return Counted(__libc_calloc(count, size)); }
void* realloc(void* memory, size_t size) noexcept {
  Forget(memory);
  return Counted(__libc_realloc(memory, size));
}
void* memalign(size_t alignment, size_t size) noexcept {
  return Counted(__libc_memalign(alignment, size));
}
void* aligned_alloc(size_t alignment, size_t size) noexcept { return memalign(alignment, size); }
int posix_memalign(void** memory, size_t alignment, size_t size) noexcept {
  *memory = memalign(alignment, size);
  return *memory == nullptr ? ENOMEM : 0;
}
void free(void* memory) noexcept {
  Forget(memory);
  __libc_free(memory);
}
}
// NOLINTEND(readability-identifier-naming)
#endif
