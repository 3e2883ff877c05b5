#pragma once
#include <string>

#include "estimator/fleet/fleet_changes.h"
#include "estimator/fleet/fleet_row.h"

namespace tagtwist::internal {

/// fleet.html: one file that opens without a network. `folder`: where it will lie, which its links
/// begin at.
std::string FormatFleetPage(const Fleet& fleet, const Fleet* old_fleet, const FleetChanges* changes,
                            const std::string& folder);

/// The link from a page in `folder` to a file: relative, percent-encoded.
std::string LinkTo(const std::string& file, const std::string& folder);

}  // namespace tagtwist::internal
