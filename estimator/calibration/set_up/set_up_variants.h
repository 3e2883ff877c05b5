#pragma once
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "estimator/calibration/set_up/set_up_fit.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A set-up read in another way: corners in another order, an image in a mirror, a map in which ids
/// run otherwise.
struct SetUpVariant {
  std::string fact, advice;                    // what it would mean
  std::array<size_t, 4> order = {0, 1, 2, 3};  // corner i as seen is the tag's corner order[i]
  bool mirrored = false;                       // columns counted from the right
  TagMap map;
};

/// All of them, without the one as given. `turns_round`: those in which a tag's corners run the
/// other way round, else those in which they do not.
std::vector<SetUpVariant> SetUpVariants(const TagMap& map, bool turns_round);

/// The tags of a frame under a variant.
SeenTags UnderVariant(const SeenTags& seen, const SetUpVariant& variant, int image_width);

}  // namespace tagtwist::internal
