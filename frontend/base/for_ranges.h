#pragma once
#include <cstddef>
#include <functional>

namespace tagtwist {

/// Does work(first, last) on ranges [first, last) that together are [0, count), perhaps several at
/// the same time. Work on one range must not touch what work on another reads or writes, nor depend
/// on where ranges end. So the caller decides about threads, and results do not depend on them.
using ForRanges = std::function<void(std::size_t count,
                                     const std::function<void(std::size_t, std::size_t)>& work)>;

/// In the caller's thread.
inline void InOneRange(std::size_t count,
                       const std::function<void(std::size_t, std::size_t)>& work) {
  if (count > 0) work(0, count);
}

}  // namespace tagtwist
