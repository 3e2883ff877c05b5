#include "estimator/fleet/fleet_page.h"

#include <cmath>
#include <filesystem>
#include <string_view>
#include <vector>

#include "estimator/fleet/figures.h"
#include "estimator/fleet/fleet_files.h"
#include "estimator/fleet/fleet_plots.h"
#include "estimator/report/html/page.h"
#include "frontend/base/format_text.h"
#include "frontend/base/number_text.h"

namespace tagtwist::internal {

// Embedded by CMake.
std::string_view FleetCss();
std::string_view FleetJs();
std::string_view ReportCss();

namespace {

std::string TitleOf(const Figure& figure) {
  return figure.unit[0] == '\0' ? figure.title
                                : std::string(figure.title) + " [" + figure.unit + "]";
}

// A cell that sorts by a number; empty where there is none.
std::string NumberCell(double value, const std::string& text) {
  if (!std::isfinite(value)) return "<td class=\"number\"></td>";
  return "<td class=\"number\" data-v=\"" + FormatNumber(value) + "\">" + EscapeHtml(text) +
         "</td>";
}

std::string FirstSentence(const std::string& text) {
  const size_t end = text.find(". ");
  return end == std::string::npos ? text : text.substr(0, end + 1);
}

std::string NameCell(const FleetRow& row, const std::string& folder) {
  const bool done = row.outcome == FleetOutcome::kDone;
  const std::string target = done ? row.folder + "/report.html" : row.log;
  const std::string name = EscapeHtml(NameOf(row));
  if (target.empty()) return "<th scope=\"row\">" + name + "</th>";
  return "<th scope=\"row\"><a href=\"" + LinkTo(target, folder) + "\">" + name + "</a></th>";
}

std::string WordsCell(const FleetRow& row) {
  const bool done = row.outcome == FleetOutcome::kDone;
  std::string out =
      "<td class=\"words\">" + EscapeHtml(FirstSentence(done ? row.verdict : row.error));
  if (done && !row.first_finding.empty()) {
    out += "<div class=\"faint\">" + EscapeHtml(FirstSentence(row.first_finding)) + "</div>";
  }
  return out + "</td>";
}

std::string RowHtml(const FleetRow& row, size_t number, const std::string& folder) {
  const bool done = row.outcome == FleetOutcome::kDone;
  const bool clean = done && row.findings == 0 && row.warnings == 0;
  const char* const state = clean ? "clean" : (done ? "told" : NameOf(row.outcome));
  std::string out = "<tr id=\"row-" + std::to_string(number) + "\" class=\"" + state + "\">" +
                    NameCell(row, folder) + "<td class=\"state\">" +
                    (clean ? "done" : (done ? "done, see" : NameOf(row.outcome))) + "</td>" +
                    WordsCell(row);
  const double share = row.frames > 0 ? row.frames_estimated / row.frames : std::nan("");
  out += NumberCell(share, Format("%.0f of %.0f", row.frames_estimated, row.frames));
  for (size_t i = 0; i < Figures().size(); ++i) {
    const double value = Figures()[i].scale * row.figures[i];
    out += NumberCell(value, Format("%.4g", value));
  }
  return out + "</tr>\n";
}

std::string TableOf(const Fleet& fleet, const std::string& folder) {
  std::vector<std::string> titles = {"recording", "run", "verdict, first finding", "frames"};
  for (const Figure& figure : Figures()) titles.push_back(TitleOf(figure));
  std::string out = "<div class=\"scroll\"><table id=\"fleet\">\n<thead><tr>";
  for (const std::string& title : titles) {
    out += "<th scope=\"col\" aria-sort=\"none\"><button type=\"button\">" + EscapeHtml(title) +
           "</button></th>";
  }
  out += "</tr></thead>\n<tbody>\n";
  for (size_t i = 0; i < fleet.rows.size(); ++i) out += RowHtml(fleet.rows[i], i, folder);
  return out + "</tbody></table></div>\n";
}

std::string PlotsHtml(const Fleet& fleet) {
  const size_t error = FigureIndex("position_rmse_m"), bound = FigureIndex("bound_position_m");
  const size_t wall = FigureIndex("wall_s");
  std::vector<ScatterPoint> errors, times;
  for (size_t i = 0; i < fleet.rows.size(); ++i) {
    const FleetRow& row = fleet.rows[i];
    errors.push_back({i, 1e3 * row.figures[bound], 1e3 * row.figures[error], NameOf(row)});
    times.push_back({i, row.frames, row.figures[wall], NameOf(row)});
  }
  std::string out;
  for (const std::string& plot : {ScatterSvg(errors, "bound [mm]", "ATE [mm]", true),
                                  ScatterSvg(times, "frames", "time [s]", false)}) {
    if (!plot.empty()) out += "<figure>" + plot + "</figure>\n";
  }
  return out.empty() ? out : "<div class=\"figures\">\n" + out + "</div>\n";
}

std::string ChangesHtml(const Fleet& fleet, const Fleet& old_fleet, const FleetChanges& changes) {
  std::string out =
      "<section id=\"against\">\n<h2>Against " + EscapeHtml(changes.old_place) + "</h2>\n";
  std::string named;
  for (const FigureChange& change : changes.figures) {
    if (change.is_named) named += "<li>" + EscapeHtml(ChangeText(change)) + "</li>\n";
  }
  for (const std::string& note : ChangeNotes(fleet, old_fleet, changes)) {
    named += "<li>" + EscapeHtml(note) + "</li>\n";
  }
  out += named.empty() ? ParagraphHtml("No difference that chance would not make.")
                       : "<ul class=\"findings\">\n" + named + "</ul>\n";
  TextTable table = {{"figure", "recordings", "new / old", "99 % interval", "larger in", "p"}};
  for (const FigureChange& change : changes.figures) {
    if (change.recordings == 0) continue;
    table.push_back({TitleOf(Figures()[change.figure]), std::to_string(change.recordings),
                     Format("%.4f", change.ratio), Format("%.4f to %.4f", change.low, change.high),
                     std::to_string(change.became_larger),
                     change.is_tested ? Format("%.2g", change.p) : std::string("not tested")});
  }
  return out + TableHtml(table) +
         ParagraphHtml(
             "Ratios are geometric means over the recordings that both have done. p is that of no "
             "change (Student's t on the logarithms, pair by pair; Holm for all figures together). "
             "What is named has p below 0.01 and changed by more than 1 %. NEES counts by how far "
             "it is from 1. Time and memory depend on what else the machines did, and are not "
             "tested.",
             "note") +
         "</section>\n";
}

std::string HeadHtml(const Fleet& fleet) {
  size_t told = 0;
  for (const FleetRow& row : fleet.rows) {
    told += row.outcome == FleetOutcome::kDone && row.findings + row.warnings > 0 ? 1 : 0;
  }
  std::string out =
      ParagraphHtml(std::to_string(fleet.rows.size()) +
                    " recordings: " + std::to_string(CountOf(fleet, FleetOutcome::kDone)) +
                    " done, of which " + std::to_string(told) + " have something to look at; " +
                    std::to_string(CountOf(fleet, FleetOutcome::kFailed)) + " failed, " +
                    std::to_string(CountOf(fleet, FleetOutcome::kUnfinished)) + " unfinished.");
  if (!fleet.rows.empty()) {
    const FleetRow& first = fleet.rows.front();
    out += ParagraphHtml(
        "tagtwist " + first.version +
            (first.program_sha256.empty() ? std::string()
                                          : ", program " + first.program_sha256.substr(0, 8)),
        "note");
  }
  return out;
}

}  // namespace

std::string LinkTo(const std::string& file, const std::string& folder) {
  namespace fs = std::filesystem;
  const std::string path = fs::absolute(file)
                               .lexically_normal()
                               .lexically_relative(fs::absolute(folder).lexically_normal())
                               .string();
  std::string out;
  for (const char c : path) {
    const auto byte = static_cast<unsigned char>(c);
    const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') ||
                       std::string_view("-._~/").find(c) != std::string_view::npos;
    out += plain ? std::string(1, c) : Format("%%%02X", byte);
  }
  return out;
}

std::string FormatFleetPage(const Fleet& fleet, const Fleet* old_fleet, const FleetChanges* changes,
                            const std::string& folder) {
  std::string out =
      "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
      "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; "
      "style-src 'unsafe-inline'; script-src 'unsafe-inline'\">\n"
      "<title>tagtwist: " +
      std::to_string(fleet.rows.size()) + " recordings</title>\n<style>\n";
  out += ReportCss();
  out += FleetCss();
  out += "</style>\n</head>\n<body>\n<h1>Recordings in " + EscapeHtml(fleet.place) + "</h1>\n" +
         HeadHtml(fleet);
  if (changes != nullptr) out += ChangesHtml(fleet, *old_fleet, *changes);
  out += "<section>\n<h2>Error and time</h2>\n" + PlotsHtml(fleet) + "</section>\n";
  out +=
      "<section>\n<h2>Recordings</h2>\n<p class=\"tools\"><label>Show <input type=\"search\" "
      "id=\"filter\" placeholder=\"a name, a word\"></label> <span id=\"shown\"></span></p>\n" +
      TableOf(fleet, folder) + "</section>\n<script>\n";
  out += FleetJs();
  return out + "</script>\n</body>\n</html>\n";
}

}  // namespace tagtwist::internal
