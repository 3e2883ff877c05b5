#pragma once
#include <string>
#include <vector>

#include "estimator/fleet/fleet_row.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The runs below a folder: those that its runs.json names (tagtwist_fleet), else one a
/// summary.json that lies there, in order of name; or those of a fleet.json. An error names the
/// file.
Result<Fleet> ReadFleet(const std::string& path);

/// Files that ReadFleet(path) reads itself; the summaries are besides.
std::vector<std::string> FilesOfFleet(const std::string& path);

/// "a: tagtwist 0.1.0 (1f2e3d4c)" and so on, where not all rows are by one program; else empty.
std::vector<std::string> ProgramsOf(const Fleet& fleet);

}  // namespace tagtwist::internal
