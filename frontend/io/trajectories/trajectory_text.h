#pragma once
#include <string>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/trajectories/trajectory_rows.h"

namespace tagtwist::internal {

/// A trajectory from the text of a file: tables (FindTrajectoryColumns), KITTI with its times.txt
/// beside it, and the exports of Motive, Vicon Nexus and Tracker, and Qualisys. `body`: which one,
/// where a file has several. Refused, with the way on: c3d, Euler angles whose order the file does
/// not tell, positions alone.
Result<TrajectoryFile> ReadTrajectoryText(std::string bytes, const std::string& path,
                                          const std::string& body, const Limits& limits = {});

}  // namespace tagtwist::internal
