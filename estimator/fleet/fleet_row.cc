#include "estimator/fleet/fleet_row.h"

namespace tagtwist::internal {

std::string NameOf(const FleetRow& row) {
  std::string values;
  for (const auto& [flag, value] : row.values) {
    values += (values.empty() ? "" : ", ") + flag + "=" + value;
  }
  return values.empty() ? row.name : row.name + " (" + values + ")";
}

const char* NameOf(FleetOutcome outcome) {
  if (outcome == FleetOutcome::kDone) return "done";
  return outcome == FleetOutcome::kFailed ? "failed" : "unfinished";
}

}  // namespace tagtwist::internal
