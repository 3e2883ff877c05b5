#pragma once
#include <string>

#include "frontend/base/result.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A paper to print on [mm].
struct Paper {
  const char* name = "a4";
  double width_mm = 210, height_mm = 297;
};
/// By its name, a4 or letter.
Result<Paper> PaperOf(const std::string& name);

/// A tag map as a PDF in true size, the pages of each plane row by row from its top left; the bytes
/// depend on nothing but the arguments. Pages end between tags where they can; where that takes
/// more than two pages a tag, as on a large field, each tag has a page of its own. A page has marks
/// at the corners of its part, the tags' ids, a bar of 100 mm, the map's axes, and says where its
/// part lies. `title`: a name for the pages. Errors: as CheckTagMap.
Result<std::string> MapPdf(const TagMap& map, const Paper& paper, const std::string& title);

}  // namespace tagtwist::internal
