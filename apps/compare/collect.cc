#include "apps/compare/collect.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "estimator/fleet/fleet_changes.h"
#include "estimator/fleet/fleet_files.h"
#include "estimator/fleet/fleet_page.h"
#include "estimator/fleet/read_fleet.h"
#include "frontend/base/files/file_set.h"
#include "frontend/base/files/run_files.h"

namespace tagtwist::internal {
namespace {

Status CheckInputsAreKept(const CollectJob& job) {
  RunFiles files;
  for (const std::string& place : job.places) {
    for (const std::string& file : FilesOfFleet(place)) files.Reads("input", file);
  }
  if (!job.against.empty()) {
    for (const std::string& file : FilesOfFleet(job.against)) files.Reads("--against", file);
  }
  const OutputSet set{job.output, {"fleet.html", "fleet.csv", "fleet.json"}, {}, {}};
  if (const auto kept = files.WritesSet("--output", set); !kept) return kept.error();
  return files.WritesStandardOutput();
}

Status CheckPrograms(const Fleet& fleet) {
  const std::vector<std::string> programs = ProgramsOf(fleet);
  if (programs.empty()) return Ok();
  return Error{fleet.place + ": results of several versions: " + programs[0] + ", " + programs[1] +
               (programs.size() > 2 ? " and more" : "") +
               ": run them again with one, or give --mix_versions"};
}

Result<Fleet> ReadAll(const std::vector<std::string>& places) {
  Fleet all;
  for (const std::string& place : places) {
    auto fleet = ReadFleet(place);
    if (!fleet) return fleet;
    all.place += (all.place.empty() ? "" : ", ") + fleet->place;
    for (FleetRow& row : fleet->rows) {
      if (places.size() > 1) row.name = fleet->place + "/" + row.name;
      all.rows.push_back(std::move(row));
    }
  }
  return all;
}

}  // namespace

Result<std::string> Collect(const CollectJob& job) {
  if (const Status kept = CheckInputsAreKept(job); !kept) return kept.error();
  const auto fleet = ReadAll(job.places);
  if (!fleet) return fleet.error();
  std::optional<Fleet> older;
  if (!job.against.empty()) {
    auto read = ReadFleet(job.against);
    if (!read) return read.error();
    older = std::move(*read);
  }
  for (const Fleet* const one : std::vector<const Fleet*>{&*fleet, older ? &*older : nullptr}) {
    if (one == nullptr || job.mix_versions) continue;
    if (const Status fine = CheckPrograms(*one); !fine) return fine.error();
  }
  std::optional<FleetChanges> changes;
  if (older) changes = CompareFleets(*older, *fleet);
  const Fleet* const old_fleet = older ? &*older : nullptr;
  const FleetChanges* const changed = changes ? &*changes : nullptr;
  auto set = FileSet::Begin(job.output);
  if (!set) return set.error();
  for (const auto& [name, text] :
       {std::pair("fleet.html", FormatFleetPage(*fleet, old_fleet, changed, job.output)),
        std::pair("fleet.csv", FormatFleetCsv(*fleet)),
        std::pair("fleet.json", FormatFleetJson(*fleet, old_fleet, changed))}) {
    if (const Status added = (*set)->Add(name, text); !added) return added.error();
  }
  if (const Status written = (*set)->Commit(); !written) return written.error();
  return FleetText(*fleet, old_fleet, changed) + "table: " + job.output + "/fleet.html\n";
}

}  // namespace tagtwist::internal
