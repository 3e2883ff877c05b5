#include "estimator/report/html/reprojection_section.h"

#include <algorithm>
#include <cmath>

#include "estimator/report/html/pictures.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// Share of an error in the largest one.
std::string Shade(double share) {
  return Format("rgba(217, 95, 2, %.2f)", 0.6 * std::clamp(share * share, 0.0, 1.0));
}

double Rms(const RatioStatistic& squares) { return std::sqrt(squares.ratio()); }

// What figures are written in: pixels, or thousandths where all are small.
struct Unit {
  double per_px = 1;
  const char* name = "pixels";
};
Unit UnitFor(double largest_px) {
  return largest_px < 0.1 ? Unit{1000, "thousandths of a pixel"} : Unit();
}
std::string Figure(double px, const Unit& unit) {
  return Format(unit.per_px * px < 10 ? "%.2g" : "%.0f", unit.per_px * px);
}

// The largest RMS of the cells with enough corners to tell.
template <typename Parts, typename SquaresOf>
double LargestRms(const Parts& parts, SquaresOf&& squares_of) {
  double largest = 0;
  for (const auto& part : parts) {
    if (squares_of(part).blocks() > 0) largest = std::max(largest, Rms(squares_of(part)));
  }
  return largest;
}

constexpr double kCellWidth = 100, kCellHeight = 75;

std::string CellSvg(const RegionErrors& cell, double x, double y, double largest) {
  if (cell.squares.blocks() == 0) return "";
  return Format("<rect x=\"%g\" y=\"%g\" width=\"%g\" height=\"%g\" style=\"fill: %s\"/>", x, y,
                kCellWidth, kCellHeight, Shade(Rms(cell.squares) / largest).c_str()) +
         Format("<text x=\"%g\" y=\"%g\" font-size=\"20\" text-anchor=\"middle\">%s</text>\n",
                x + 0.5 * kCellWidth, y + kCellHeight - 6,
                Figure(Rms(cell.squares), UnitFor(largest)).c_str());
}

std::string ArrowSvg(const RegionErrors& cell, double x, double y, double px_to_picture) {
  if (cell.squares.blocks() < RatioStatistic::kLeastBlocks) return "";
  const double cx = x + 0.5 * kCellWidth, cy = y + 0.42 * kCellHeight;
  return Format("<line class=\"arrow\" x1=\"%.1f\" y1=\"%.1f\" x2=\"%.1f\" y2=\"%.1f\"/>", cx, cy,
                cx + px_to_picture * cell.u.ratio(), cy + px_to_picture * cell.v.ratio()) +
         Format("<circle class=\"arrow-foot\" cx=\"%.1f\" cy=\"%.1f\" r=\"3\"/>\n", cx, cy);
}

double LongestMean(const ReprojectionErrorsByPlace& errors) {
  double longest = 0;
  for (const RegionErrors& cell : errors.cells) {
    if (cell.squares.blocks() < RatioStatistic::kLeastBlocks) continue;
    longest = std::max(longest, std::hypot(cell.u.ratio(), cell.v.ratio()));
  }
  return longest;
}

std::string ByTagHtml(const ReprojectionErrorsByPlace& errors, const TagMap& map) {
  const auto squares_of = [](const auto& entry) { return entry.second.squares; };
  const double largest = LargestRms(errors.tags, squares_of);
  std::map<int, TagMark> marks;
  for (const auto& [id, tag] : errors.tags) {
    if (tag.squares.blocks() == 0) continue;
    marks[id] = {Figure(Rms(tag.squares), UnitFor(largest)), Shade(Rms(tag.squares) / largest)};
  }
  return "<h3>By tag</h3>\n" +
         ParagraphHtml(
             "The map, with the RMS error of each tag's corners in pixels; tags that were "
             "not in use have their ids.",
             "note") +
         MapPictureSvg(map, {}, marks);
}

double LargestCell(const ReprojectionErrorsByPlace& errors) {
  return LargestRms(errors.cells, [](const RegionErrors& cell) { return cell.squares; });
}

std::string ByPlaceHtml(const ReprojectionErrorsByPlace& errors) {
  std::string note = Format(
      "The image in cells, with the RMS error of the corners in each, in %s. Chance points "
      "in all directions.",
      UnitFor(LargestCell(errors)).name);
  if (const double longest = LongestMean(errors); longest > 0) {
    note += Format(
        " The lines go from the dot the way that corners are off on average, the longest by %.2g "
        "px: neighbours that agree speak of the lens, or of the map.",
        longest);
  }
  return "<h3>By place in the image</h3>\n" + ParagraphHtml(note, "note") + ImageErrorsSvg(errors);
}

// Ids that are written: every one, or every so many, where rows are that high.
size_t LabelStep(double row) { return static_cast<size_t>(std::ceil(12 / row)); }

}  // namespace

std::string ImageErrorsSvg(const ReprojectionErrorsByPlace& errors) {
  const double largest = LargestCell(errors);
  if (!(largest > 0)) return "";
  constexpr int kColumns = ReprojectionErrorsByPlace::kColumns;
  constexpr int kRows = ReprojectionErrorsByPlace::kRows;
  std::string cells, arrows;
  const double longest = LongestMean(errors);
  for (size_t i = 0; i < errors.cells.size(); ++i) {
    const double x = kCellWidth * static_cast<double>(i % kColumns);
    const double y = kCellHeight * static_cast<double>(i / kColumns);
    cells += CellSvg(errors.cells[i], x, y, largest);
    if (longest > 0) arrows += ArrowSvg(errors.cells[i], x, y, 0.4 * kCellHeight / longest);
  }
  return Format(
             "<div class=\"picture narrow\"><svg role=\"img\" aria-label=\"errors by place in the "
             "image\" viewBox=\"0 0 %g %g\">\n",
             kColumns * kCellWidth, kRows * kCellHeight) +
         cells + arrows + "</svg></div>\n";
}

std::string TagsOverTimeSvg(const ReprojectionErrorsByPlace& errors, int64_t t0_ns) {
  constexpr double kLeft = 50, kWidth = 750, kFoot = 24;
  double end_s = 0;
  for (const auto& [id, tag] : errors.tags) {
    if (!tag.seen.empty()) end_s = std::max(end_s, ToSeconds(tag.seen.back().last_ns - t0_ns));
  }
  if (!(end_s > 0)) return "";
  const size_t rows = errors.tags.size();
  const double row = std::clamp(320.0 / static_cast<double>(rows), 5.0, 16.0);
  const double height = row * static_cast<double>(rows);
  std::string out = Format(
      "<div class=\"picture\"><svg role=\"img\" aria-label=\"tags over time\" viewBox=\"0 0 %g "
      "%g\">\n",
      kLeft + kWidth + 10, height + kFoot);
  size_t k = 0;
  for (const auto& [id, tag] : errors.tags) {
    const double y = row * static_cast<double>(k);
    if (k++ % LabelStep(row) == 0) {
      out += Format("<text x=\"%g\" y=\"%.1f\" font-size=\"11\" text-anchor=\"end\">%d</text>",
                    kLeft - 6, y + 0.5 * row + 4, id);
    }
    for (const TagErrors::Interval& seen : tag.seen) {
      const double from = ToSeconds(seen.first_ns - t0_ns) / end_s * kWidth;
      const double to = ToSeconds(seen.last_ns - t0_ns) / end_s * kWidth;
      out += Format("<rect class=\"bar\" x=\"%.1f\" y=\"%.1f\" width=\"%.1f\" height=\"%.1f\"/>",
                    kLeft + from, y + 0.1 * row, std::max(1.0, to - from), 0.8 * row);
    }
    out += "\n";
  }
  const double step = NiceStep(end_s, 8);
  for (int i = 0; i * step <= end_s; ++i) {
    out +=
        Format("<text x=\"%.1f\" y=\"%.1f\" font-size=\"12\" text-anchor=\"middle\">%g s</text>\n",
               kLeft + i * step / end_s * kWidth, height + 17, i * step);
  }
  return out + "</svg></div>\n";
}

ReportSection ReprojectionSection(const Estimate& estimate, const TagMap& map) {
  const ReprojectionErrorsByPlace& errors = estimate.reprojection;
  ReportSection out;
  out.title = "Reprojection";
  out.html =
      ParagraphHtml("Distance of every tag corner from where the estimate puts it, in pixels.",
                    "note") +
      HistogramSvg(estimate.reprojection_px, "px");
  if (errors.squares.blocks() == 0) return out;
  out.html += ByPlaceHtml(errors) + ByTagHtml(errors, map);
  return out;
}

}  // namespace tagtwist::internal
