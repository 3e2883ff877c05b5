#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Of stamps as they come, those that grow strictly.
struct GrowingStamps {
  std::vector<size_t> kept;  // indices, ascending
  size_t repeated = 0, backward = 0;
  size_t first_passed_over = 0;  // index, where any was

  bool All() const { return repeated + backward == 0; }
};

/// Passes over each stamp that repeats or runs backwards against the last that was kept. An error
/// (without any name) where no more than half is left: then the order is not that of time.
Result<GrowingStamps> KeepGrowing(const std::vector<int64_t>& stamps_ns);

/// "passed over 3 of 100 frames: 2 stamps repeat, 1 runs backwards (the first: PLACE)".
std::string PassedOverText(const GrowingStamps& growing, const std::string& what,
                           const std::string& place);
/// The same where so many were kept.
std::string PassedOverText(const GrowingStamps& growing, size_t kept, const std::string& what,
                           const std::string& place);

}  // namespace tagtwist::internal
