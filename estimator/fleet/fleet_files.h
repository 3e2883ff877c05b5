#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/fleet/fleet_changes.h"
#include "estimator/fleet/fleet_row.h"

namespace tagtwist::internal {

/// A row a recording; columns by name, figures in SI units, empty where they are not known.
std::string FormatFleetCsv(const Fleet& fleet);

/// {rows, counts, programs}, and with an older fleet `against` {place, named, figures, outcomes,
/// ...}.
std::string FormatFleetJson(const Fleet& fleet, const Fleet* old_fleet,
                            const FleetChanges* changes);

/// What tagtwist_compare prints: a line a recording that is not done, and a last one of all.
std::string FleetText(const Fleet& fleet, const Fleet* old_fleet, const FleetChanges* changes);

/// How many rows ended so.
size_t CountOf(const Fleet& fleet, FleetOutcome outcome);

/// What is worth telling of a comparison besides the figures, a sentence each.
std::vector<std::string> ChangeNotes(const Fleet& fleet, const Fleet& old_fleet,
                                     const FleetChanges& changes);

}  // namespace tagtwist::internal
