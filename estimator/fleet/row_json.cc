#include "estimator/fleet/row_json.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "estimator/fleet/figures.h"
#include "frontend/base/files/input_digest.h"

namespace tagtwist::internal {
namespace {

using Json = nlohmann::ordered_json;

constexpr double kMostCount = 1e12;
constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

std::string TextAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_string() ? found->get<std::string>() : std::string();
}

double NumberOf(const Json& json) { return json.is_number() ? json.get<double>() : kUnknown; }

double NumberAt(const Json& json, const std::string& pointer) {
  const Json::json_pointer place(pointer);
  return json.contains(place) ? NumberOf(json.at(place)) : kUnknown;
}

double CountAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  const double count = found != json.end() ? NumberOf(*found) : 0;
  return count >= 0 ? std::min(count, kMostCount) : 0;
}

size_t EntriesAt(const Json& json, const char* key) {
  const auto found = json.find(key);
  return found != json.end() && found->is_array() ? found->size() : 0;
}

FleetOutcome OutcomeOf(const std::string& name) {
  for (const FleetOutcome outcome : {FleetOutcome::kDone, FleetOutcome::kFailed}) {
    if (name == NameOf(outcome)) return outcome;
  }
  return FleetOutcome::kUnfinished;
}

// Digest of the digests of all that --dataset read.
std::string TablesOf(const Json& summary) {
  std::string all;
  const auto inputs = summary.find("inputs");
  if (inputs == summary.end() || !inputs->is_array()) return "";
  for (const Json& input : *inputs) {
    if (!input.is_object() || TextAt(input, "flag") != "--dataset") continue;
    all += TextAt(input, "sha256") + "\n";
  }
  return all.empty() ? "" : DigestText(all);
}

// Numbers that are not known are null, which JSON has no other word for.
Json NumberJson(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

}  // namespace

Json RowJson(const FleetRow& row) {
  Json out = {{"recording", row.name}};
  out["values"] = Json::object();
  for (const auto& [flag, value] : row.values) out["values"][flag] = value;
  out["outcome"] = NameOf(row.outcome);
  out["error"] = row.error;
  out["verdict"] = row.verdict;
  out["first_finding"] = row.first_finding;
  out["findings"] = row.findings;
  out["warnings"] = row.warnings;
  out["frames"] = row.frames;
  out["frames_estimated"] = row.frames_estimated;
  for (size_t i = 0; i < Figures().size(); ++i) {
    out[Figures()[i].key] = NumberJson(i < row.figures.size() ? row.figures[i] : kUnknown);
  }
  out["folder"] = row.folder;
  out["version"] = row.version;
  out["program_sha256"] = row.program_sha256;
  out["tables_sha256"] = row.tables_sha256;
  return out;
}

FleetRow RowOfJson(const Json& json) {
  FleetRow out;
  out.figures.assign(Figures().size(), kUnknown);
  if (!json.is_object()) return out;
  out.name = TextAt(json, "recording");
  if (const auto values = json.find("values"); values != json.end() && values->is_object()) {
    for (const auto& [flag, value] : values->items()) {
      out.values.emplace_back(flag, value.is_string() ? value.get<std::string>() : value.dump());
    }
  }
  out.outcome = OutcomeOf(TextAt(json, "outcome"));
  out.error = TextAt(json, "error");
  out.verdict = TextAt(json, "verdict");
  out.first_finding = TextAt(json, "first_finding");
  out.findings = static_cast<size_t>(CountAt(json, "findings"));
  out.warnings = static_cast<size_t>(CountAt(json, "warnings"));
  out.frames = CountAt(json, "frames");
  out.frames_estimated = CountAt(json, "frames_estimated");
  for (size_t i = 0; i < out.figures.size(); ++i) {
    out.figures[i] = NumberAt(json, std::string("/") + Figures()[i].key);
  }
  out.folder = TextAt(json, "folder");
  out.version = TextAt(json, "version");
  out.program_sha256 = TextAt(json, "program_sha256");
  out.tables_sha256 = TextAt(json, "tables_sha256");
  return out;
}

void AddSummary(const Json& summary, FleetRow* row) {
  row->tables_sha256 = TablesOf(summary);
  row->warnings = EntriesAt(summary, "warnings");
  if (row->version.empty()) row->version = TextAt(summary, "version");
  if (row->outcome != FleetOutcome::kDone) {
    if (row->error.empty()) row->error = TextAt(summary, "error");
    return;
  }
  row->verdict = TextAt(summary, "verdict");
  row->findings = EntriesAt(summary, "findings");
  const Json::json_pointer first("/findings/0");
  if (summary.contains(first) && summary.at(first).is_object()) {
    row->first_finding = TextAt(summary.at(first), "fact");
  } else if (const Json::json_pointer warning("/warnings/0");
             summary.contains(warning) && summary.at(warning).is_string()) {
    row->first_finding = summary.at(warning).get<std::string>();
  }
  row->frames = CountAt(summary, "frames");
  row->frames_estimated = CountAt(summary, "frames_estimated");
  for (size_t i = 0; i < row->figures.size(); ++i) {
    row->figures[i] = NumberAt(summary, Figures()[i].pointer);
  }
}

FleetRow RowOfRun(const Json& run) {
  FleetRow out = RowOfJson(run);
  if (!run.is_object()) return out;
  out.name = TextAt(run, "name");
  out.log = TextAt(run, "log");
  return out;
}

}  // namespace tagtwist::internal
