#include "estimator/report/files/camera_found.h"

#include <Eigen/Core>
#include <cmath>
#include <vector>

#include "estimator/report/files/calibration_config.h"
#include "frontend/base/format_text.h"
#include "frontend/base/units.h"
#include "residuals/lens.h"

namespace tagtwist::internal {
namespace {

// A letter a cell of the image.
std::vector<std::string> CoverageLines(const ViewsJudged& views) {
  std::vector<std::string> out;
  for (int row = 0; row < ViewsJudged::kRows; ++row) {
    out.emplace_back();
    for (int column = 0; column < ViewsJudged::kColumns; ++column) {
      const int n = views.corners[static_cast<size_t>(ViewsJudged::kColumns * row + column)];
      out.back() += n == 0 ? " ." : n < 10 ? " o" : n < 100 ? " O" : " @";
    }
  }
  return out;
}

std::string LensLine(const LensFound& found) {
  const Camera& camera = found.calibration.set_up.rig.front().camera;
  return Format("%d x %d px, fx %.2f, fy %.2f (+- %.2g %%), cx %.2f, cy %.2f (+- %.2g px), ",
                camera.width, camera.height, camera.fx, camera.fy,
                100 * found.inflation() * found.calibration.sigma(kLogFocal), camera.cx, camera.cy,
                found.inflation() * found.calibration.sigma(kCentreX)) +
         ToString(found.kind);
}

std::string BesidesLine(const LensFound& found) {
  const Calibration& c = found.calibration;
  std::string out;
  if (found.besides.line_time) {
    const int entry = LayoutOf(c.given).line_time();
    out += Format("a rolling shutter, %.2f us a row (+- %.2g)",
                  1e6 * c.set_up.rig.front().line_time_s, 1e6 * found.inflation() * c.sigma(entry));
  }
  if (!found.besides.map) return out;
  if (found.besides.map_always) {
    return out + (out.empty() ? "" : "; ") +
           Format("learned with it: where the %zu tags are, all of one size", c.given.tags.size());
  }
  double squares = 0;
  for (size_t i = 0; i < c.given.tags.size(); ++i) {
    squares += (c.refined.tags[i].world_from_tag.translation() -
                c.given.tags[i].world_from_tag.translation())
                   .squaredNorm();
  }
  const double rms_m = std::sqrt(squares / static_cast<double>(c.given.tags.size()));
  return out + (out.empty() ? "" : "; ") +
         Format("refined with it: the tags' places, by %.2f mm (RMS)", 1e3 * rms_m);
}

// Cells as light squares, grey where no corner was seen, and a dot a corner.
std::string ImagePart(const LensFound& found) {
  const Camera& camera = found.calibration.set_up.rig.front().camera;
  const double w = static_cast<double>(camera.width) / ViewsJudged::kColumns;
  const double h = static_cast<double>(camera.height) / ViewsJudged::kRows;
  std::string out;
  for (int row = 0; row < ViewsJudged::kRows; ++row) {
    for (int column = 0; column < ViewsJudged::kColumns; ++column) {
      const int n = found.views.corners[static_cast<size_t>(ViewsJudged::kColumns * row + column)];
      out += Format(
          "<rect x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\" fill=\"%s\" "
          "stroke=\"#ccc\"><title>%d corners</title></rect>\n",
          w * column, h * row, w, h, n == 0 ? "#e0b0a0" : "#fff", n);
    }
  }
  out += Format("<path stroke=\"#06c\" stroke-linecap=\"round\" stroke-width=\"%.1f\" d=\"",
                camera.width / 250.0);
  for (const Eigen::Vector2d& pixel : found.views.pixels) {
    out += Format("M%.1f %.1fh0", pixel.x() + 0.5, pixel.y() + 0.5);
  }
  return out + "\"/>\n";
}

std::string SvgHead(const Camera& camera, double height) {
  return Format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 %d %.0f\">\n",
                camera.width, height) +
         "<title>Corners that the camera saw</title>\n";
}

}  // namespace

std::vector<std::string> CameraFigures(const LensFound& found) {
  std::vector<std::string> out = {
      LensLine(found),
      Format(
          "frames left out reproject at %.3f px a coordinate; %d frames of %d views that differ, "
          "tilted by up to %.0f deg; halves differ by %.1f sigmas",
          found.calibration.validation.refined.corner_sigma_px, found.calibration.frames,
          found.views.distinct, kDegreesPerRadian * found.views.tilt_rad, found.halves_ratio)};
  if (const std::string line = BesidesLine(found); !line.empty()) out.push_back(line);
  return out;
}

std::string CoverageSvg(const LensFound& found) {
  const Camera& camera = found.calibration.set_up.rig.front().camera;
  return SvgHead(camera, camera.height) + ImagePart(found) + "</svg>\n";
}

std::string CameraVerdict(const LensFound& found) {
  if (found.missing.empty()) return "good: nothing speaks against it";
  std::string out = "not good: ";
  for (const std::string& line : found.missing) {
    out += (&line == found.missing.data() ? "" : "; ") + line;
  }
  return out;
}

std::string CameraFoundText(const LensFound& found) {
  std::string out;
  for (const std::string& line : CameraFigures(found)) {
    out += (out.empty() ? "camera     " : "           ") + line + "\n";
  }
  for (const std::string& line : CoverageLines(found.views)) out += "           " + line + "\n";
  return out + "verdict    " + CameraVerdict(found) + "\n";
}

std::string CameraFoundConfig(const LensFound& found) {
  std::string out = "# By tagtwist_camera; +- is one standard deviation";
  out += Format(" (that of the fit times %.2f, so that it holds).\n", found.inflation());
  for (const std::string& line : CameraFigures(found)) out += "# " + line + "\n";
  out += "# " + CameraVerdict(found) +
         "\n# Corners seen, by place in the image (. none, o some, O ten, @ a hundred):\n";
  for (const std::string& line : CoverageLines(found.views)) out += "#   " + line + "\n";
  return out + CameraText(found.calibration, found.inflation());
}

std::string CameraFoundSvg(const LensFound& found) {
  const Camera& camera = found.calibration.set_up.rig.front().camera;
  const double line = camera.width / 40.0;
  std::vector<std::string> lines = CameraFigures(found);
  lines.push_back(found.missing.empty() ? CameraVerdict(found) : "not good:");
  lines.insert(lines.end(), found.missing.begin(), found.missing.end());
  std::string out = SvgHead(camera, camera.height + line * static_cast<double>(lines.size() + 1));
  out += "<rect width=\"100%\" height=\"100%\" fill=\"#fff\"/>\n" + ImagePart(found);
  for (size_t i = 0; i < lines.size(); ++i) {
    out += Format("<text x=\"%.1f\" y=\"%.1f\" font-family=\"sans-serif\" font-size=\"%.1f\">",
                  line / 2, camera.height + line * (static_cast<double>(i) + 1), line / 2.5) +
           lines[i] + "</text>\n";
  }
  return out + "</svg>\n";
}

}  // namespace tagtwist::internal
