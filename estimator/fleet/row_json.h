#pragma once
#include <nlohmann/json_fwd.hpp>

#include "estimator/fleet/fleet_row.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A row as fleet.json has it.
nlohmann::ordered_json RowJson(const FleetRow& row);
/// Its inverse; what is not there, or not of its type, is as in an empty row.
FleetRow RowOfJson(const nlohmann::ordered_json& json);

/// What summary.json says of a run that is done, or failed, into its row.
void AddSummary(const nlohmann::ordered_json& summary, FleetRow* row);

/// A row of tagtwist_fleet's runs.json, without its summary.
FleetRow RowOfRun(const nlohmann::ordered_json& run);

}  // namespace tagtwist::internal
