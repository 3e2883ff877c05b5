#pragma once
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Equal tags whose places nobody knows, and an image of which nothing is known but its size.
struct LayoutSought {
  int width = 0, height = 0;  // [px]
  std::string family = "tag36h11";
  double tag_size_m = 0;  // > 0; only the layout's scale hangs on it, and no lens
};

/// Where the tags of one sheet of paper are, as homographies say: the tag seen most often is the
/// plane's origin; the others come one after the other, the one that most frames see beside placed
/// ones first, where the median frame has it. What bends lines is taken out by the equidistant lens
/// under which the frames agree best. An error where no other tag can be placed, or one is of
/// another size.
Result<TagMap> SheetByHomographies(const std::vector<FrameMeasurements>& frames,
                                   const LayoutSought& sought);

/// The frames with those of their tags that the map has; frames that keep fewer than two are left
/// out.
std::vector<FrameMeasurements> OfMap(const std::vector<FrameMeasurements>& frames,
                                     const TagMap& map);

/// The layout for a lens to be calibrated by: that of a sheet, then by MapTags under the lens that
/// starts from it, twice, which bends no sheet flat. Tags that could not be placed are not in it.
Result<TagMap> LayoutFromNothing(const std::vector<FrameMeasurements>& frames,
                                 const LayoutSought& sought);

}  // namespace tagtwist::internal
