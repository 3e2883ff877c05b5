#pragma once
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// What --collect asks for.
struct CollectJob {
  std::vector<std::string> places;  // of fleets, or folders with results below them
  std::string output;               // folder
  std::string against;              // an older fleet; empty: none
  bool mix_versions = false;
};

/// Gathers all runs in fleet.html, fleet.csv and fleet.json in the output folder, all of them or
/// none. Returns what is to be printed. Runs of several versions are refused unless they are asked
/// for.
Result<std::string> Collect(const CollectJob& job);

}  // namespace tagtwist::internal
