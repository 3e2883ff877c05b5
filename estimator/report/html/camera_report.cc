#include "estimator/report/html/camera_report.h"

#include "estimator/calibration/lens/lens_numbers.h"
#include "estimator/report/files/camera_found.h"
#include "estimator/report/html/page.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

ReportSection LensSection(const LensFound& found) {
  ReportSection out;
  out.title = "Lens";
  for (const std::string& line : CameraFigures(found)) out.html += ParagraphHtml(line);
  TextTable table;
  table.push_back({"", "value", "one standard deviation"});
  for (const LensNumber& number : NumbersOf(found)) {
    table.push_back({number.name + (number.unit.empty() ? "" : " [" + number.unit + "]"),
                     Format("%.7g", number.value), Format("%.2g", number.sigma)});
  }
  out.html += TableHtml(table);
  out.html += ParagraphHtml(
      Format("The standard deviations are those of the fit times %.2f, so that they hold.",
             found.inflation()));
  return out;
}

ReportSection CoverageSection(const LensFound& found) {
  ReportSection out;
  out.title = "Where the image was covered";
  out.html = ParagraphHtml(Format(
      "%.0f %% of the image's cells saw corners; those that saw none are marked. Where the image "
      "saw none the lens is what the rest of it says.",
      100 * found.views.covered()));
  out.html += CoverageSvg(found);
  return out;
}

}  // namespace

std::string CameraReportHtml(const LensFound& found, const std::string& recording) {
  ReportPage page;
  page.title = "Camera of " + recording;
  page.html = ParagraphHtml("The calibration is " + CameraVerdict(found) + ".");
  page.sections = {LensSection(found), CoverageSection(found)};
  return FormatReportPage(page);
}

}  // namespace tagtwist::internal
