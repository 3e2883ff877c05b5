#pragma once
#include <optional>
#include <string>

#include "frontend/io/tables/text_grid.h"
#include "frontend/io/trajectories/trajectory_rows.h"

namespace tagtwist::internal {

/// Exports of motion capture programs. nullopt: the grid is none of them. `body`: the rigid body's
/// name; may be empty where there is but one.
/// Motive (OptiTrack), CSV: rigid bodies with quaternions, in the units that its first line tells.
std::optional<Result<TrajectoryFile>> ReadMotive(const TextGrid& grid, const std::string& path,
                                                 const std::string& body);
/// Vicon Nexus and Tracker, CSV: TX TY TZ in the units below the names, RX RY RZ a rotation vector
/// (angle times axis, rad or deg), or with RW a quaternion. A frame's time is its number over the
/// rate, which stands above.
std::optional<Result<TrajectoryFile>> ReadVicon(const TextGrid& grid, const std::string& path,
                                                const std::string& body);
/// Qualisys Track Manager, TSV of 6D data: positions in mm and the rotation matrix Rot[0]..Rot[8],
/// column by column. Its Euler angles have an order that the file does not tell: refused.
std::optional<Result<TrajectoryFile>> ReadQualisys(const TextGrid& grid, const std::string& path,
                                                   const std::string& body);

}  // namespace tagtwist::internal
