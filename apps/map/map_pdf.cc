#include "apps/map/map_pdf.h"

#include <cairo/cairo-pdf.h>

#include <algorithm>
#include <memory>
#include <vector>

#include "estimator/report/files/map_sheets.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

constexpr double kPointsPerMm = 72 / 25.4;
constexpr double kMarginMm = 12, kFootMm = 18;  // the foot holds the bar, the axes and the text

// What a page shows of a sheet.
struct Part {
  Eigen::AlignedBox2d box_mm;
  std::string name;
};

// Where pages begin along one axis: at most `most_mm` apart, between the intervals where that can
// be. Intervals that are longer than a page are cut.
std::vector<double> Breaks(std::vector<std::pair<double, double>> intervals, double most_mm) {
  std::sort(intervals.begin(), intervals.end());
  double end = intervals.front().second;
  for (const auto& [low, high] : intervals) end = std::max(end, high);
  std::vector<double> out = {intervals.front().first};
  while (out.back() + most_mm < end) {
    double next = out.back() + most_mm;
    for (const auto& [low, high] : intervals) {
      if (low > out.back() && low < next && high > next) next = low;
    }
    out.push_back(next);
  }
  out.push_back(end);
  return out;
}

std::vector<Part> TilesOf(const MapSheet& sheet, const Eigen::Vector2d& room_mm) {
  std::vector<std::pair<double, double>> across, down;  // down: from the top
  for (const SheetTag& tag : sheet.tags) {
    across.emplace_back(tag.paper_mm.min().x(), tag.paper_mm.max().x());
    down.emplace_back(-tag.paper_mm.max().y(), -tag.paper_mm.min().y());
  }
  const std::vector<double> x = Breaks(across, room_mm.x()), y = Breaks(down, room_mm.y());
  std::vector<Part> out;
  for (size_t row = 0; row + 1 < y.size(); ++row) {
    for (size_t column = 0; column + 1 < x.size(); ++column) {
      Part part;
      part.box_mm.extend(Eigen::Vector2d(x[column], -y[row]));
      part.box_mm.extend(Eigen::Vector2d(x[column + 1], -y[row + 1]));
      const bool shown = std::any_of(sheet.tags.begin(), sheet.tags.end(), [&](const SheetTag& t) {
        const Eigen::Vector2d common = part.box_mm.intersection(t.paper_mm).sizes();
        return common.x() > 1e-6 && common.y() > 1e-6;
      });
      part.name = Format("row %zu of %zu, column %zu of %zu", row + 1, y.size() - 1, column + 1,
                         x.size() - 1);
      if (shown) out.push_back(part);
    }
  }
  return out;
}

// Tiles, or where these are many against the tags, those of each tag.
std::vector<Part> PartsOf(const MapSheet& sheet, const Eigen::Vector2d& room_mm) {
  std::vector<Part> tiles = TilesOf(sheet, room_mm);
  if (tiles.size() <= 2 * sheet.tags.size()) return tiles;
  std::vector<Part> out;
  for (const SheetTag& tag : sheet.tags) {
    MapSheet alone;
    alone.tags.push_back(tag);
    for (Part part : TilesOf(alone, room_mm)) {
      part.name = Format("tag %d: ", tag.id) + part.name;
      out.push_back(std::move(part));
    }
  }
  return out;
}

cairo_status_t Append(void* to, const unsigned char* bytes, unsigned int size) {
  static_cast<std::string*>(to)->append(reinterpret_cast<const char*>(bytes), size);
  return CAIRO_STATUS_SUCCESS;
}

void DrawText(cairo_t* page, double x_mm, double y_mm, double size_mm, const std::string& text) {
  cairo_select_font_face(page, "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  cairo_set_font_size(page, size_mm);
  cairo_move_to(page, x_mm, y_mm);
  cairo_show_text(page, text.c_str());
}

void DrawLine(cairo_t* page, double x_mm, double y_mm, double to_x_mm, double to_y_mm) {
  cairo_move_to(page, x_mm, y_mm);
  cairo_line_to(page, to_x_mm, to_y_mm);
  cairo_stroke(page);
}

// A tag where (0, 0) is the part's left top, y down; its id stands under its paper.
void DrawTag(cairo_t* page, const SheetTag& tag, const Eigen::Vector2d& left_top_mm) {
  const Eigen::Vector2d at(tag.left_top_mm.x() - left_top_mm.x(),
                           left_top_mm.y() - tag.left_top_mm.y());
  const Eigen::Vector2d across = tag.cell_mm * Eigen::Vector2d(tag.right.x(), -tag.right.y());
  const Eigen::Vector2d down = tag.cell_mm * Eigen::Vector2d(-tag.up.x(), tag.up.y());
  for (const CellRun& run : BlackRuns(tag.pattern)) {
    const Eigen::Vector2d begin = at + run.column * across + run.row * down;
    const Eigen::Vector2d end = begin + run.length * across;
    cairo_move_to(page, begin.x(), begin.y());
    cairo_line_to(page, end.x(), end.y());
    cairo_line_to(page, end.x() + down.x(), end.y() + down.y());
    cairo_line_to(page, begin.x() + down.x(), begin.y() + down.y());
    cairo_close_path(page);
  }
  cairo_set_source_rgb(page, 0, 0, 0);
  cairo_fill(page);  // all at once, so that no seams show
  cairo_set_source_rgb(page, 0.6, 0.6, 0.6);
  const double size_mm = std::min(3.0, 0.5 * tag.cell_mm);
  DrawText(page, tag.paper_mm.min().x() - left_top_mm.x(),
           left_top_mm.y() - tag.paper_mm.min().y() + size_mm, size_mm, std::to_string(tag.id));
}

// Outside the corners of the part, so that pages can be cut and laid edge to edge.
void DrawMarks(cairo_t* page, const Eigen::Vector2d& size_mm) {
  constexpr double kFrom = 1, kTo = 7;
  cairo_set_source_rgb(page, 0, 0, 0);
  cairo_set_line_width(page, 0.1);
  for (const bool right : {false, true}) {
    for (const bool low : {false, true}) {
      const double x = right ? size_mm.x() : 0, y = low ? size_mm.y() : 0;
      const double out_x = right ? 1 : -1, out_y = low ? 1 : -1;
      DrawLine(page, x + out_x * kFrom, y, x + out_x * kTo, y);
      DrawLine(page, x, y + out_y * kFrom, x, y + out_y * kTo);
    }
  }
}

// The map's axes as the sheet shows them; those that stand on it are left out.
void DrawAxes(cairo_t* page, const Pose& world_from_sheet, double x_mm, double y_mm) {
  constexpr double kLengthMm = 9;
  const Eigen::Matrix3d axes = world_from_sheet.rotation().toRotationMatrix().transpose();
  for (int axis = 0; axis < 3; ++axis) {
    const Eigen::Vector2d along = kLengthMm * axes.col(axis).head<2>();
    if (along.norm() < 0.3 * kLengthMm) continue;
    DrawLine(page, x_mm, y_mm, x_mm + along.x(), y_mm - along.y());
    DrawText(page, x_mm + 1.2 * along.x() - 0.5, y_mm - 1.2 * along.y() + 0.8, 2.5,
             std::string(1, static_cast<char>('x' + axis)));
  }
}

void DrawFoot(cairo_t* page, const Paper& paper, const Pose& world_from_sheet,
              const std::string& text, const std::string& where) {
  constexpr double kBarMm = 100;
  const double y_mm = paper.height_mm - kMarginMm + 2;
  cairo_set_source_rgb(page, 0, 0, 0);
  cairo_set_line_width(page, 0.2);
  DrawLine(page, kMarginMm, y_mm, kMarginMm + kBarMm, y_mm);
  for (int i = 0; i <= 10; ++i) {
    const double x_mm = kMarginMm + 0.1 * i * kBarMm;
    DrawLine(page, x_mm, y_mm, x_mm, y_mm - (i % 5 == 0 ? 2 : 1));
  }
  DrawText(page, kMarginMm + kBarMm + 2, y_mm, 2.5, "100 mm: print at 100 %");
  DrawText(page, kMarginMm, y_mm + 3.5, 2.5, text);
  DrawText(page, kMarginMm, y_mm + 6.5, 2.5, where);
  DrawAxes(page, world_from_sheet, paper.width_mm - 26, paper.height_mm - 16);
}

std::string WhereText(const MapSheet& sheet, const Part& part) {
  const auto in_map = [&](const Eigen::Vector2d& mm) -> Eigen::Vector3d {
    return sheet.world_from_sheet * Eigen::Vector3d(1e-3 * mm.x(), 1e-3 * mm.y(), 0);
  };
  const Eigen::Vector3d low = in_map(part.box_mm.min()), high = in_map(part.box_mm.max());
  return Format("lower left (%.4f, %.4f, %.4f) m, upper right (%.4f, %.4f, %.4f) m of the map",
                low.x(), low.y(), low.z(), high.x(), high.y(), high.z());
}

void DrawPage(cairo_t* page, const Paper& paper, const MapSheet& sheet, const Part& part,
              const std::string& text) {
  const Eigen::Vector2d left_top(part.box_mm.min().x(), part.box_mm.max().y());
  const Eigen::Vector2d size = part.box_mm.sizes();
  cairo_save(page);
  cairo_translate(page, kMarginMm, kMarginMm);
  cairo_save(page);
  cairo_rectangle(page, 0, 0, size.x(), size.y() + 0.1);
  cairo_clip(page);
  for (const SheetTag& tag : sheet.tags) {
    if (!part.box_mm.intersection(tag.paper_mm).isEmpty()) DrawTag(page, tag, left_top);
  }
  cairo_restore(page);
  DrawMarks(page, size);
  cairo_restore(page);
  DrawFoot(page, paper, sheet.world_from_sheet, text, WhereText(sheet, part));
  cairo_show_page(page);
}

}  // namespace

Result<Paper> PaperOf(const std::string& name) {
  if (name == "a4") return Paper();
  if (name == "letter") return Paper{"letter", 215.9, 279.4};
  return Error{"expected a4 or letter, got " + name};
}

Result<std::string> MapPdf(const TagMap& map, const Paper& paper, const std::string& title) {
  const auto sheets = MapSheets(map);
  if (!sheets) return sheets.error();
  const Eigen::Vector2d room(paper.width_mm - 2 * kMarginMm, paper.height_mm - kMarginMm - kFootMm);
  std::vector<std::vector<Part>> parts;
  size_t pages = 0, number = 0;
  for (const MapSheet& sheet : *sheets) {
    parts.push_back(PartsOf(sheet, room));
    pages += parts.back().size();
  }
  std::string bytes;
  const std::unique_ptr<cairo_surface_t, void (*)(cairo_surface_t*)> surface(
      cairo_pdf_surface_create_for_stream(Append, &bytes, paper.width_mm * kPointsPerMm,
                                          paper.height_mm * kPointsPerMm),
      cairo_surface_destroy);
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_TITLE, title.c_str());
  cairo_pdf_surface_set_metadata(surface.get(), CAIRO_PDF_METADATA_CREATE_DATE,
                                 "2000-01-01T00:00:00Z");  // the same bytes at any time
  const std::unique_ptr<cairo_t, void (*)(cairo_t*)> page(cairo_create(surface.get()),
                                                          cairo_destroy);
  cairo_scale(page.get(), kPointsPerMm, kPointsPerMm);
  for (size_t s = 0; s < sheets->size(); ++s) {
    for (const Part& part : parts[s]) {
      DrawPage(page.get(), paper, (*sheets)[s], part,
               title +
                   Format(", page %zu of %zu: plane %zu of %zu, ", ++number, pages, s + 1,
                          sheets->size()) +
                   part.name);
    }
  }
  cairo_surface_finish(surface.get());
  if (cairo_surface_status(surface.get()) != CAIRO_STATUS_SUCCESS) {
    return Error{"the PDF cannot be drawn: " +
                 std::string(cairo_status_to_string(cairo_surface_status(surface.get())))};
  }
  return bytes;
}

}  // namespace tagtwist::internal
