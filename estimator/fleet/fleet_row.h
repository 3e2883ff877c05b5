#pragma once
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace tagtwist::internal {

/// How a recording's run ended. kUnfinished: it was ended from outside, or has not begun.
enum class FleetOutcome { kDone, kFailed, kUnfinished };

/// A recording's run, as a row of the table.
struct FleetRow {
  std::string name;
  std::vector<std::pair<std::string, std::string>> values;  // flags that the list sweeps over
  std::string folder;                                       // of its results
  std::string log;                                          // what it printed; empty: not kept
  FleetOutcome outcome = FleetOutcome::kDone;
  std::string error;           // of a run that is not done
  std::string version;         // of the program
  std::string program_sha256;  // of its file; empty: not known
  std::string tables_sha256;   // of the recording's tables, as one text; empty: not known
  std::string verdict, first_finding;
  size_t findings = 0, warnings = 0;
  double frames = 0, frames_estimated = 0;
  std::vector<double> figures;  // as Figures(); NaN: not known
};

/// The rows of one fleet.
struct Fleet {
  std::string place;  // the folder or file that they are from
  std::vector<FleetRow> rows;
};

/// Name and swept values of a row in one text, for people: "flight (camera_file=a.yaml)".
std::string NameOf(const FleetRow& row);
/// "done", "failed", "unfinished".
const char* NameOf(FleetOutcome outcome);

}  // namespace tagtwist::internal
