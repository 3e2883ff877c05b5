#include "estimator/report/html/calibration_section.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "estimator/report/files/calibration_text.h"
#include "estimator/report/html/pictures.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// Red above, blue below, the stronger the farther.
std::string ColourOf(double share) {
  return Format("rgba(%s, %.2f)", share > 0 ? "214, 69, 65" : "58, 124, 214",
                0.85 * std::min(1.0, std::abs(share)));
}

}  // namespace

ReportSection CalibrationSection(const Calibration& calibration) {
  ReportSection section;
  section.title = "Calibration";
  for (const std::string& line : CalibrationText(calibration)) {
    section.html += ParagraphHtml(line);
  }
  const std::vector<TagMove> moves = TagMoves(calibration);
  double highest_m = 0;
  for (const TagMove& move : moves) highest_m = std::max(highest_m, std::abs(move.up_m));
  if (!(highest_m > 0)) return section;
  std::map<int, TagMark> marks;
  for (const TagMove& move : moves) {
    marks[move.id] = {Format("%+.1f", 1e3 * move.up_m), ColourOf(move.up_m / highest_m)};
  }
  section.html += ParagraphHtml(
      "Tags as refined, with how far each lies above (red) or below (blue) where the map had it, "
      "in mm.");
  section.html += MapPictureSvg(calibration.set_up.map, {}, marks);
  return section;
}

ReportSection RigSection(const RigCalibration& rig) {
  ReportSection section;
  section.title = "Calibration";
  for (const std::string& line : RigText(rig)) section.html += ParagraphHtml(line);
  return section;
}

}  // namespace tagtwist::internal
