#include "estimator/report/files/mapping_text.h"

#include <cmath>
#include <vector>

#include "frontend/base/format_text.h"
#include "frontend/io/setup/tag_map_text.h"

namespace tagtwist::internal {

std::string MappingText(const Mapping& mapping) {
  std::vector<std::string> notes;
  for (const auto& covariance : mapping.covariances) {
    const double position_m = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
    const double rotation_rad = std::sqrt(covariance.topLeftCorner<3, 3>().trace());
    notes.push_back(
        position_m > 0 ? Format("+- %.1f mm, %.2f deg", 1e3 * position_m, rotation_rad * 180 / M_PI)
                       : "fixed");
  }
  std::string out = Format("# %zu tags mapped, corner noise %.3f px\n", mapping.map.tags().size(),
                           mapping.corner_sigma_px);
  for (const int id : mapping.left_out) {
    out += Format("# tag %d was seen, and could not be placed\n", id);
  }
  return out + FormatTagMap(mapping.map, notes);
}

}  // namespace tagtwist::internal
