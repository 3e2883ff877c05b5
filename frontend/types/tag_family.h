#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"

struct apriltag_family;  // libapriltag's apriltag_family_t

namespace tagtwist::internal {

using TagFamilyPointer = std::unique_ptr<apriltag_family, std::function<void(apriltag_family*)>>;

/// The family of the tags on Kalibr's boards: codes of tag36h11 in a black border of two cells.
inline constexpr const char* kKalibrFamily = "tag36h11b2";

/// The names of libapriltag's families, "tag36h11" first, and kKalibrFamily.
std::vector<std::string> TagFamilyNames();

/// A family by its name. A detector keeps data of its own in it, so each detector needs its own.
Result<TagFamilyPointer> CreateTagFamily(const std::string& name);

/// How many tags the family has: ids 0..n - 1. An unknown name is an error.
Result<int> TagFamilySize(const std::string& name);

/// A tag as a grid of cells, paper included: row 0 is the top as printed.
struct TagPattern {
  int cells = 0;         // side of the grid: the tag with one white cell of paper around it
  int outer_cells = 0;   // paper (and, in some families, data) cells before the square's first cell
  int square_cells = 0;  // cells along the square whose corners are p1..p4 (Tag::size_m)
  std::vector<uint8_t> white;  // 0 or 1; cells x cells, row by row

  bool IsWhite(int column, int row) const {
    return white[static_cast<size_t>(row) * static_cast<size_t>(cells) +
                 static_cast<size_t>(column)] != 0;
  }
};

/// The patterns of the given ids; an id that the family lacks is an error.
Result<std::vector<TagPattern>> MakeTagPatterns(const std::string& family,
                                                const std::vector<int>& ids);

}  // namespace tagtwist::internal
