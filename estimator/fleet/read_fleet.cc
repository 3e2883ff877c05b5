#include "estimator/fleet/read_fleet.h"

#include <algorithm>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "estimator/fleet/row_json.h"
#include "estimator/report/files/read_json.h"
#include "frontend/base/files/file_set.h"
#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kDeepest = 6;  // folders that a summary may lie below

// Whether a path leads to what lies below where it begins.
bool LeadsDown(const fs::path& path) {
  return !path.empty() && path.is_relative() &&
         std::find(path.begin(), path.end(), fs::path("..")) == path.end();
}

// What a run's folder says, into its row.
Status AddRun(const fs::path& folder, FleetRow* row) {
  std::error_code unknown;
  row->folder = folder.string();
  const fs::path path = folder / "summary.json";
  if (!fs::is_regular_file(path, unknown)) {
    if (row->outcome != FleetOutcome::kDone) return Ok();
    return Error{path.string() + ": is missing, and its run is told to be done"};
  }
  if (!IsFileSetWhole(folder.string())) {
    return Error{folder.string() +
                 ": a run was ended while it replaced these results: run it again"};
  }
  const auto summary = ReadJsonObject(path.string());
  if (!summary) return summary.error();
  AddSummary(*summary, row);
  return Ok();
}

Result<Fleet> ReadRuns(const fs::path& folder) {
  const fs::path path = folder / "runs.json";
  const auto json = ReadJsonObject(path.string());
  if (!json) return json.error();
  const auto runs = json->find("runs");
  if (runs == json->end() || !runs->is_array()) {
    return Error{path.string() + ": runs: expected a list, as tagtwist_fleet writes it"};
  }
  Fleet out{folder.string(), {}};
  for (const Json& run : *runs) {
    FleetRow row = RowOfRun(run);
    if (row.name.empty() || !LeadsDown(row.folder)) {
      return Error{path.string() + ": runs[" + std::to_string(out.rows.size()) +
                   "]: expected a name, and a folder below this one"};
    }
    if (!row.log.empty()) row.log = (folder / row.log).string();
    if (const Status added = AddRun(folder / row.folder, &row); !added) return added.error();
    out.rows.push_back(std::move(row));
  }
  return out;
}

Result<Fleet> FindRuns(const fs::path& folder) {
  std::error_code failure;
  std::vector<fs::path> found;
  for (fs::recursive_directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    if (entry.depth() >= kDeepest) entry.disable_recursion_pending();
    if (entry->path().filename() == "summary.json") found.push_back(entry->path().parent_path());
  }
  if (failure) return Error{folder.string() + ": cannot read: " + failure.message()};
  std::sort(found.begin(), found.end());
  Fleet out{folder.string(), {}};
  for (const fs::path& place : found) {
    FleetRow row = RowOfJson(Json());
    const auto summary = ReadJsonObject((place / "summary.json").string());
    if (!summary) return summary.error();
    const auto status = summary->find("status");
    const bool failed = status != summary->end() && *status == "failed";
    row.outcome = failed ? FleetOutcome::kFailed : FleetOutcome::kDone;
    row.name = place.lexically_relative(folder).string();
    if (const Status added = AddRun(place, &row); !added) return added.error();
    out.rows.push_back(std::move(row));
  }
  if (out.rows.empty()) return Error{folder.string() + ": holds no results of tagtwist_estimate"};
  return out;
}

Result<Fleet> ReadTable(const std::string& path) {
  const auto json = ReadJsonObject(path);
  if (!json) return json.error();
  const auto rows = json->find("rows");
  if (rows == json->end() || !rows->is_array()) {
    return Error{path + ": rows: expected a list, as in a fleet.json"};
  }
  Fleet out{path, {}};
  for (const Json& row : *rows) out.rows.push_back(RowOfJson(row));
  return out;
}

}  // namespace

std::vector<std::string> FilesOfFleet(const std::string& path) {
  std::error_code unknown;
  if (!fs::is_directory(path, unknown)) return {path};
  return {(fs::path(path) / "runs.json").string()};
}

Result<Fleet> ReadFleet(const std::string& path) {
  std::error_code unknown;
  if (!fs::is_directory(path, unknown)) return ReadTable(path);
  fs::path folder = fs::path(path).lexically_normal();
  if (!folder.has_filename()) folder = folder.parent_path();
  return fs::is_regular_file(folder / "runs.json", unknown) ? ReadRuns(folder) : FindRuns(folder);
}

std::vector<std::string> ProgramsOf(const Fleet& fleet) {
  std::map<std::pair<std::string, std::string>, std::string> programs;  // to the first of its rows
  for (const FleetRow& row : fleet.rows) {
    programs.emplace(std::pair(row.version, row.program_sha256), NameOf(row));
  }
  std::vector<std::string> out;
  for (const auto& [program, name] : programs) {
    const auto& [version, sha256] = program;
    out.push_back(QuoteForMessage(name) + " by version " + (version.empty() ? "unknown" : version) +
                  (sha256.empty() ? "" : " (" + sha256.substr(0, 8) + ")"));
  }
  return out.size() > 1 ? out : std::vector<std::string>();
}

}  // namespace tagtwist::internal
