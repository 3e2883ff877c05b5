#include "frontend/tag_family.h"

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

namespace tagtwist {
namespace {

struct FamilyMaker {
  const char* name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};

constexpr std::array<FamilyMaker, 9> kFamilies = {{
    {"tag36h11", tag36h11_create, tag36h11_destroy},
    {"tag36h10", tag36h10_create, tag36h10_destroy},
    {"tag25h9", tag25h9_create, tag25h9_destroy},
    {"tag16h5", tag16h5_create, tag16h5_destroy},
    {"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    {"tagCircle49h12", tagCircle49h12_create, tagCircle49h12_destroy},
    {"tagCustom48h12", tagCustom48h12_create, tagCustom48h12_destroy},
    {"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
    {"tagStandard52h13", tagStandard52h13_create, tagStandard52h13_destroy},
}};

// libapriltag's own drawing has a white rim where the square is black; the families with a
// reversed border have data out to the edge instead, and get the rim here.
TagPattern DrawPattern(apriltag_family_t* family, int id) {
  const std::unique_ptr<image_u8_t, void (*)(image_u8_t*)> image(apriltag_to_image(family, id),
                                                                 image_u8_destroy);
  const int rim = family->reversed_border ? 1 : 0;
  TagPattern out;
  out.square_cells = family->width_at_border;
  out.cells = image->width + 2 * rim;
  out.outer_cells = (out.cells - out.square_cells) / 2;
  for (int row = -rim; row < image->height + rim; ++row) {
    for (int column = -rim; column < image->width + rim; ++column) {
      const bool inside = row >= 0 && column >= 0 && row < image->height && column < image->width;
      out.white.push_back(!inside || image->buf[row * image->stride + column] > 127);
    }
  }
  return out;
}

}  // namespace

std::vector<std::string> TagFamilyNames() {
  std::vector<std::string> out;
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
    out.push_back(DrawPattern(family->get(), id));
  }
  return out;
}

}  // namespace tagtwist
