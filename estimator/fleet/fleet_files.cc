#include "estimator/fleet/fleet_files.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "estimator/fleet/figures.h"
#include "estimator/fleet/row_json.h"
#include "estimator/report/files/summary_json.h"
#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

using Json = nlohmann::ordered_json;

// RFC 4180.
std::string Cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::string ValuesText(const FleetRow& row) {
  std::string out;
  for (const auto& [flag, value] : row.values) out += (out.empty() ? "" : " ") + flag + "=" + value;
  return out;
}

Json ChangesJson(const Fleet& fleet, const Fleet& old_fleet, const FleetChanges& changes) {
  Json out = {{"place", changes.old_place}, {"named", Json::array()}, {"figures", Json::object()}};
  for (const FigureChange& change : changes.figures) {
    const char* const key = Figures()[change.figure].key;
    if (change.is_named) {
      out["named"].push_back({{"figure", key},
                              {"sign", change.ratio > 1 ? "worse" : "better"},
                              {"text", ChangeText(change)}});
    }
    out["figures"][key] = {{"recordings", change.recordings},
                           {"became_larger", change.became_larger},
                           {"ratio", change.ratio},
                           {"interval99", {change.low, change.high}},
                           {"p", change.is_tested ? Json(change.p) : Json(nullptr)}};
  }
  out["single"] = Json::array();
  for (const RecordingChange& change : changes.single) {
    out["single"].push_back({{"recording", NameOf(fleet.rows[change.new_row])},
                             {"figure", Figures()[change.figure].key},
                             {"ratio", change.ratio},
                             {"sign", change.ratio > 1 ? "worse" : "better"}});
  }
  out["outcomes"] = Json::array();
  for (const OutcomeChange& change : changes.outcomes) {
    const FleetRow& now = fleet.rows[change.new_row];
    out["outcomes"].push_back({{"recording", NameOf(now)},
                               {"was", NameOf(old_fleet.rows[change.old_row].outcome)},
                               {"is", NameOf(now.outcome)}});
  }
  out["only_here"] = changes.only_new;
  out["only_there"] = changes.only_old;
  out["other_tables"] = changes.other_tables;
  return out;
}

// Without what a terminal would obey.
std::string OneLine(std::string text) {
  std::replace_if(
      text.begin(), text.end(),
      [](char c) { return static_cast<unsigned char>(c) < 0x20 || c == 0x7f; }, '?');
  return text;
}

std::string Plural(size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace

size_t CountOf(const Fleet& fleet, FleetOutcome outcome) {
  return static_cast<size_t>(
      std::count_if(fleet.rows.begin(), fleet.rows.end(),
                    [&](const FleetRow& row) { return row.outcome == outcome; }));
}

std::string FormatFleetCsv(const Fleet& fleet) {
  std::string out =
      "recording,values,outcome,verdict,first_finding,findings,warnings,frames,frames_estimated";
  for (const Figure& figure : Figures()) out += std::string(",") + figure.key;
  out += ",folder,version,program_sha256,error\n";
  for (const FleetRow& row : fleet.rows) {
    out += Cell(row.name) + "," + Cell(ValuesText(row)) + "," + NameOf(row.outcome) + "," +
           Cell(row.verdict) + "," + Cell(row.first_finding) + "," + std::to_string(row.findings) +
           "," + std::to_string(row.warnings) + "," + FormatNumber(row.frames) + "," +
           FormatNumber(row.frames_estimated);
    for (const double value : row.figures) {
      out += "," + (std::isfinite(value) ? FormatNumber(value) : std::string());
    }
    out += "," + Cell(row.folder) + "," + Cell(row.version) + "," + Cell(row.program_sha256) + "," +
           Cell(row.error) + "\n";
  }
  return out;
}

std::string FormatFleetJson(const Fleet& fleet, const Fleet* old_fleet,
                            const FleetChanges* changes) {
  Json out = Json::object();
  out["place"] = fleet.place;
  out["counts"] = Json::object();
  for (const FleetOutcome outcome :
       {FleetOutcome::kDone, FleetOutcome::kFailed, FleetOutcome::kUnfinished}) {
    out["counts"][NameOf(outcome)] = CountOf(fleet, outcome);
  }
  if (changes != nullptr) out["against"] = ChangesJson(fleet, *old_fleet, *changes);
  out["rows"] = Json::array();
  for (const FleetRow& row : fleet.rows) out["rows"].push_back(RowJson(row));
  return FormatJson(out);
}

std::vector<std::string> ChangeNotes(const Fleet& fleet, const Fleet& old_fleet,
                                     const FleetChanges& changes) {
  std::vector<std::string> out;
  for (const OutcomeChange& change : changes.outcomes) {
    const FleetRow& now = fleet.rows[change.new_row];
    out.push_back(NameOf(now) + " is " + NameOf(now.outcome) + " now, and was " +
                  NameOf(old_fleet.rows[change.old_row].outcome) +
                  (now.error.empty() ? "." : ": " + now.error));
  }
  for (const RecordingChange& change : changes.single) out.push_back(ChangeText(change, fleet));
  if (changes.only_new > 0) out.push_back(Plural(changes.only_new, "recording") + " only here.");
  if (changes.only_old > 0) out.push_back(Plural(changes.only_old, "recording") + " only there.");
  if (changes.other_tables > 0) {
    out.push_back("Of " + Plural(changes.other_tables, "recording") +
                  " the tables are not the same in both: data are compared, too.");
  }
  return out;
}

std::string FleetText(const Fleet& fleet, const Fleet* old_fleet, const FleetChanges* changes) {
  std::string out;
  for (const FleetRow& row : fleet.rows) {
    if (row.outcome == FleetOutcome::kDone) continue;
    out += OneLine(std::string(NameOf(row.outcome)) + ": " + NameOf(row) + ": " + row.error) + "\n";
  }
  if (changes != nullptr) {
    const size_t before = out.size();
    for (const FigureChange& change : changes->figures) {
      if (change.is_named) out += "changed: " + ChangeText(change) + "\n";
    }
    for (const std::string& note : ChangeNotes(fleet, *old_fleet, *changes)) {
      out += OneLine("changed: " + note) + "\n";
    }
    if (out.size() == before) out += "against " + changes->old_place + ": no difference\n";
  }
  const size_t done = CountOf(fleet, FleetOutcome::kDone);
  return out + std::to_string(done) + " of " + Plural(fleet.rows.size(), "recording") + " done\n";
}

}  // namespace tagtwist::internal
