#pragma once
#include <algorithm>
#include <cstddef>
#include <deque>
#include <future>
#include <thread>
#include <utility>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The number of threads asked for; 0 stands for the machine's own number.
inline int ResolveThreads(int asked) {
  if (asked > 0) return asked;
  return static_cast<int>(std::max(1U, std::thread::hardware_concurrency()));
}

/// Calls use(i, make(i)) for i = 0..count - 1 in order, in the caller's thread, while up to
/// `threads` later ones are being made in threads of their own. Stops at the first error of `use`.
template <typename Make, typename Use>
Status ForEachInOrder(size_t count, int threads, const Make& make, const Use& use) {
  std::deque<std::future<decltype(make(size_t{0}))>> pending;
  size_t started = 0;
  for (size_t i = 0; i < count; ++i) {
    while (started < count && pending.size() < static_cast<size_t>(std::max(1, threads))) {
      pending.push_back(std::async(std::launch::async, make, started++));
    }
    auto made = pending.front().get();
    pending.pop_front();
    if (started < count) pending.push_back(std::async(std::launch::async, make, started++));
    if (auto used = use(i, std::move(made)); !used) return used;
  }
  return Ok();
}

}  // namespace tagtwist::internal
