#pragma once
#include <random>
#include <vector>

#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

using Rng = std::mt19937_64;

inline double Draw(Rng* rng, double low, double high) {
  return std::uniform_real_distribution<double>(low, high)(*rng);
}

/// Adds random corners under an id of the map, in the place of a tag that has it.
void AddPhantom(const TagMap& map, Rng* rng, std::vector<TagDetection>* tags);

}  // namespace tagtwist::internal
