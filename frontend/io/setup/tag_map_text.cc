#include "frontend/io/setup/tag_map_text.h"

#include "frontend/base/number_text.h"

namespace tagtwist::internal {

std::string FormatNumberList(const Eigen::VectorXd& values) {
  std::string out;
  for (const double value : values) out += (out.empty() ? "" : ", ") + FormatNumber(value);
  return "[" + out + "]";
}

std::string FormatTagMap(const TagMap& map, const std::vector<std::string>& notes) {
  std::string out = "tag_map:\n  family: " + map.family() + "\n  tags:\n";
  for (size_t i = 0; i < map.tags().size(); ++i) {
    const Tag& tag = map.tags()[i];
    out += "    - {id: " + std::to_string(tag.id) + ", size_m: " + FormatNumber(tag.size_m) +
           ", position_m: " + FormatNumberList(tag.world_from_tag.translation()) +
           ", quaternion_xyzw: " + FormatNumberList(tag.world_from_tag.params.head<4>());
    if (tag.bend_m != 0) out += ", bend_m: " + FormatNumber(tag.bend_m);
    out += "}";
    if (!notes.empty()) out += "  # " + notes[i];
    out += "\n";
  }
  return out;
}

}  // namespace tagtwist::internal
