#include "tests/support/situations/phantoms.h"

#include <algorithm>
#include <cmath>

namespace tagtwist::internal {
namespace {

constexpr double kTurn = 6.283185307179586;

// Random corners under an id of the map.
TagDetection Phantom(const TagMap& map, Rng* rng) {
  TagDetection out;
  out.id =
      map.tags()[static_cast<size_t>(Draw(rng, 0, 0.999) * static_cast<double>(map.tags().size()))]
          .id;
  const double y = Draw(rng, 60, 180), x = Draw(rng, 60, 300);
  const Eigen::Vector2d centre(x, y);
  const double size = Draw(rng, 15, 40), turn = Draw(rng, 0, kTurn);
  for (size_t c = 0; c < 4; ++c) {
    const double angle = turn - kTurn / 4 * static_cast<double>(c);
    const double high = Draw(rng, 0.8, 1.2), wide = Draw(rng, 0.8, 1.2);
    out.corners[c] =
        centre + size * Eigen::Vector2d(std::cos(angle) * wide, std::sin(angle) * high);
  }
  return out;
}

}  // namespace

void AddPhantom(const TagMap& map, Rng* rng, std::vector<TagDetection>* tags) {
  const TagDetection phantom = Phantom(map, rng);
  const auto same = [&](const TagDetection& tag) { return tag.id == phantom.id; };
  tags->erase(std::remove_if(tags->begin(), tags->end(), same), tags->end());
  tags->push_back(phantom);
}

}  // namespace tagtwist::internal
