#include "frontend/types/tag_family.h"

#include <algorithm>
#include <array>
extern "C" {
#include <apriltag/apriltag.h>
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>
}

namespace tagtwist::internal {
namespace {

struct FamilyMaker {
  const char* name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

// Kalibr's tags: two black cells around the code where libapriltag has one.
apriltag_family_t* CreateWideBorder36h11() {
  apriltag_family_t* family = tag36h11_create();
  family->width_at_border += 2;
  family->total_width += 2;
  for (uint32_t bit = 0; bit < family->nbits; ++bit) {
    ++family->bit_x[bit];
    ++family->bit_y[bit];
  }
  return family;
}

constexpr std::array<FamilyMaker, 10> kFamilies = {{
    {"tag36h11", tag36h11_create, tag36h11_destroy},
    {"tag36h10", tag36h10_create, tag36h10_destroy},
    {"tag25h9", tag25h9_create, tag25h9_destroy},
    {"tag16h5", tag16h5_create, tag16h5_destroy},
    {"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    {"tagCircle49h12", tagCircle49h12_create, tagCircle49h12_destroy},
    {"tagCustom48h12", tagCustom48h12_create, tagCustom48h12_destroy},
    {"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
    {"tagStandard52h13", tagStandard52h13_create, tagStandard52h13_destroy},
    {kKalibrFamily, CreateWideBorder36h11, tag36h11_destroy},
}};

// The cells that the family says something about: all, but where the border is
// reversed: its bits and the border, a black ring around a white one.
std::vector<bool> ToldCells(const apriltag_family_t& family, int cells, int outer_cells, int ring) {
  std::vector<bool> out(static_cast<size_t>(cells) * static_cast<size_t>(cells), false);
  for (int row = 0; row < cells; ++row) {
    for (int column = 0; column < cells; ++column) {
      const int edge = std::min({row, column, cells - 1 - row, cells - 1 - column});
      out[static_cast<size_t>(row * cells + column)] =
          !family.reversed_border || edge == ring || edge == ring - 1;
    }
  }
  for (uint32_t bit = 0; bit < family.nbits; ++bit) {
    const int column = static_cast<int>(family.bit_x[bit]) + outer_cells;
    const int row = static_cast<int>(family.bit_y[bit]) + outer_cells;
    out[static_cast<size_t>(row * cells + column)] = true;
  }
  return out;
}

// The grid of cells libapriltag means: black but for a white ring (the square's outer ring of cells
// where the family's border is reversed, the ring around the square elsewhere) and the white bits,
// the code's first bit being its highest. Families with a reversed border have data out to the
// edge; they get a rim of paper. `black_rim_corners`: as the squares between Kalibr's tags leave
// it.
TagPattern DrawPattern(const apriltag_family_t& family, int id, bool black_rim_corners) {
  TagPattern out;
  out.square_cells = family.width_at_border;
  out.cells = family.total_width + (family.reversed_border ? 2 : 0);
  out.outer_cells = (out.cells - out.square_cells) / 2;
  const int ring = family.reversed_border ? out.outer_cells : out.outer_cells - 1;
  const std::vector<bool> told = ToldCells(family, out.cells, out.outer_cells, ring);
  for (int row = 0; row < out.cells; ++row) {
    for (int column = 0; column < out.cells; ++column) {
      const int edge = std::min({row, column, out.cells - 1 - row, out.cells - 1 - column});
      const bool open = !told[out.white.size()];  // left to whoever prints it: paper
      const bool white = edge == ring || (family.reversed_border && edge == 0) || open;
      out.white.push_back(white ? 1 : 0);
    }
  }
  if (black_rim_corners) {
    const size_t last = static_cast<size_t>(out.cells) - 1, row = last + 1;
    for (const size_t corner : {size_t{0}, last, last * row, last * row + last}) {
      out.white[corner] = 0;
    }
  }
  for (uint32_t bit = 0; bit < family.nbits; ++bit) {
    if ((family.codes[id] >> (family.nbits - bit - 1) & 1U) == 0) continue;
    const int column = static_cast<int>(family.bit_x[bit]) + out.outer_cells;
    const int row = static_cast<int>(family.bit_y[bit]) + out.outer_cells;
    out.white[static_cast<size_t>(row) * static_cast<size_t>(out.cells) +
              static_cast<size_t>(column)] = 1;
  }
  return out;
}

}  // namespace

std::vector<std::string> TagFamilyNames() {
  std::vector<std::string> out;
  out.reserve(kFamilies.size());
  for (const FamilyMaker& family : kFamilies) out.emplace_back(family.name);
  return out;
}

Result<TagFamilyPointer> CreateTagFamily(const std::string& name) {
  std::string known;
  for (const FamilyMaker& family : kFamilies) {
    if (name == family.name) return TagFamilyPointer(family.create(), family.destroy);
    known += known.empty() ? family.name : std::string(", ") + family.name;
  }
  return Error{"tag family: expected one of " + known + ", got '" + name + "'"};
}

Result<int> TagFamilySize(const std::string& name) {
  const auto family = CreateTagFamily(name);
  if (!family) return family.error();
  return static_cast<int>((*family)->ncodes);
}

Result<std::vector<TagPattern>> MakeTagPatterns(const std::string& family_name,
                                                const std::vector<int>& ids) {
  auto family = CreateTagFamily(family_name);
  if (!family) return family.error();
  std::vector<TagPattern> out;
  for (const int id : ids) {
    if (id < 0 || static_cast<uint32_t>(id) >= (*family)->ncodes) {
      return Error{"tag " + std::to_string(id) + ": " + family_name + " has ids 0.." +
                   std::to_string((*family)->ncodes - 1)};
    }
    out.push_back(DrawPattern(**family, id, family_name == kKalibrFamily));
  }
  return out;
}

}  // namespace tagtwist::internal
