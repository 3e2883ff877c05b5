#include "estimator/report/html/pictures.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

namespace tagtwist::internal {
namespace {

// Picture coordinates: right = y of W, down = x of W, in metres.
Eigen::Vector2d ToPicture(const Eigen::Vector3d& point_in_world) {
  return {point_in_world.y(), point_in_world.x()};
}

[[gnu::format(printf, 2, 0)]] std::string Text(double value, const char* format = "%.4g") {
  std::array<char, 40> text;
  std::snprintf(text.data(), text.size(), format, value);
  return text.data();
}

std::string PointText(const Eigen::Vector2d& p) {
  return Text(p.x(), "%.3f") + "," + Text(p.y(), "%.3f");
}

Eigen::AlignedBox2d Extent(const TagMap& map, const std::vector<PicturePath>& paths) {
  Eigen::AlignedBox2d box;
  for (const Tag& tag : map.tags()) {
    for (const auto& corner : map.CornersInWorld(tag.id)) box.extend(ToPicture(corner));
  }
  for (const PicturePath& path : paths) {
    if (!path.sets_extent) continue;
    for (const PoseSample& s : path.series) {
      box.extend(ToPicture(s.world_from_body.translation()));
    }
  }
  if (box.isEmpty()) box.extend(Eigen::Vector2d::Zero());
  const double margin = std::max(0.05, 0.05 * box.sizes().maxCoeff());
  return {box.min().array() - margin, box.max().array() + margin};
}

std::string LineSvg(double x1, double y1, double x2, double y2) {
  return "<line class=\"grid\" x1=\"" + Text(x1) + "\" y1=\"" + Text(y1) + "\" x2=\"" + Text(x2) +
         "\" y2=\"" + Text(y2) + "\"/>\n";
}

std::string TextSvg(double x, double y, double size, const std::string& anchor,
                    const std::string& text, const std::string& css_class = "") {
  return "<text" + (css_class.empty() ? "" : " class=\"" + css_class + "\"") + " x=\"" + Text(x) +
         "\" y=\"" + Text(y) + "\" font-size=\"" + Text(size) + "\" text-anchor=\"" + anchor +
         "\">" + text + "</text>\n";
}

std::string GridSvg(const Eigen::AlignedBox2d& box) {
  const double step = NiceStep(box.sizes().maxCoeff(), 10);
  const double size = 0.014 * box.sizes().maxCoeff();
  std::string out;
  const auto first = [step](double low) { return static_cast<int>(std::ceil(low / step)); };
  for (int k = first(box.min().x()); k * step < box.max().x(); ++k) {
    out += LineSvg(k * step, box.min().y(), k * step, box.max().y());
    out += TextSvg(k * step, box.max().y() - 0.4 * size, size, "middle", "y " + Text(k * step));
  }
  for (int k = first(box.min().y()); k * step < box.max().y(); ++k) {
    out += LineSvg(box.min().x(), k * step, box.max().x(), k * step);
    out += TextSvg(box.min().x() + 0.4 * size, k * step - 0.3 * size, size, "start",
                   "x " + Text(k * step));
  }
  return out;
}

std::string TagsSvg(const TagMap& map, const std::map<int, TagMark>& marks) {
  std::string out;
  for (const Tag& tag : map.tags()) {
    out += "<polygon class=\"tag\" points=\"";
    for (const auto& corner : map.CornersInWorld(tag.id)) out += PointText(ToPicture(corner)) + " ";
    out.back() = '"';
    const auto mark = marks.find(tag.id);
    if (mark != marks.end()) out += " style=\"fill: " + mark->second.colour + "\"";
    out += "/>";
    const Eigen::Vector2d centre = ToPicture(tag.world_from_tag.translation());
    out += TextSvg(centre.x(), centre.y() + 0.12 * tag.size_m, 0.36 * tag.size_m, "middle",
                   mark != marks.end() ? mark->second.label : std::to_string(tag.id),
                   mark != marks.end() ? "mark" : "");
  }
  return out;
}

std::string PathSvg(const PicturePath& path) {
  constexpr size_t kMaxPoints = 4000;
  const size_t step = path.series.size() / kMaxPoints + 1;
  std::string out = "<polyline class=\"path s" + std::to_string(path.slot % 10) +
                    "\" data-slot=\"" + std::to_string(path.slot) + "\" points=\"";
  for (size_t i = 0; i < path.series.size(); i += step) {
    const Eigen::Vector2d p = ToPicture(path.series[i].world_from_body.translation());
    if (p.allFinite()) out += PointText(p) + " ";
  }
  return out + "\"/>\n";
}

}  // namespace

double NiceStep(double span, int most) {
  const double base = std::pow(10.0, std::floor(std::log10(span / most)));
  for (const double factor : {1.0, 2.0, 5.0}) {
    if (factor * base * most >= span) return factor * base;
  }
  return 10 * base;
}

std::string MapPictureSvg(const TagMap& map, const std::vector<PicturePath>& paths,
                          const std::map<int, TagMark>& marks) {
  const Eigen::AlignedBox2d box = Extent(map, paths);
  std::string out =
      "<div class=\"picture\"><svg class=\"zoomable\" role=\"img\" "
      "aria-label=\"trajectory from above\" viewBox=\"";
  out += Text(box.min().x()) + " " + Text(box.min().y()) + " " + Text(box.sizes().x()) + " " +
         Text(box.sizes().y()) + "\">\n";
  out += TagsSvg(map, marks) + GridSvg(box);
  for (const PicturePath& path : paths) out += PathSvg(path);
  return out + "</svg></div>\n";
}

std::string HistogramSvg(std::vector<double> values, const std::string& unit) {
  constexpr int kBars = 40;
  constexpr double kWidth = 800, kHeight = 200, kFoot = 24;
  if (values.empty()) return "";
  std::sort(values.begin(), values.end());
  const double top = values[static_cast<size_t>(0.99 * static_cast<double>(values.size() - 1))];
  const double width = std::max(top, 1e-9) / (kBars - 1);
  std::array<size_t, kBars> counts = {};
  for (const double v : values) {
    counts[static_cast<size_t>(std::clamp(v / width, 0.0, kBars - 1.0))]++;
  }
  const auto most = static_cast<double>(*std::max_element(counts.begin(), counts.end()));
  std::string out =
      "<div class=\"picture\"><svg role=\"img\" aria-label=\"histogram\" viewBox=\"0 0 " +
      Text(kWidth) + " " + Text(kHeight + kFoot) + "\">\n";
  const double bar = kWidth / kBars;
  for (int k = 0; k < kBars; ++k) {
    const double height = kHeight * 0.95 * static_cast<double>(counts[k]) / most;
    out += "<rect class=\"bar\" x=\"" + Text(k * bar + 1, "%.1f") + "\" y=\"" +
           Text(kHeight - height, "%.1f") + "\" width=\"" + Text(bar - 2, "%.1f") + "\" height=\"" +
           Text(height, "%.1f") + "\"/>\n";
  }
  const double span = width * (kBars - 1), step = NiceStep(span, 8);
  for (int k = 0; k * step < 0.93 * span; ++k) {  // room for the last word
    out += TextSvg(k * step / width * bar, kHeight + 17, 13, k == 0 ? "start" : "middle",
                   Text(k * step) + (k == 0 ? " " + unit : ""));
  }
  out += TextSvg(kWidth - 2, kHeight + 17, 13, "end", "more");
  return out + "</svg></div>\n";
}

}  // namespace tagtwist::internal
