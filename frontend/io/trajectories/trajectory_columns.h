#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/tables/stamp_unit.h"
#include "frontend/io/tables/text_grid.h"

namespace tagtwist::internal {

/// Where a table has a trajectory's numbers.
struct TrajectoryColumns {
  std::string form;  // for messages: "TUM", "a table with names"
  size_t stamp = 0;
  std::optional<StampUnit> stamp_unit;  // where the table tells it
  std::vector<size_t> pose;             // x y z qx qy qz qw
  double metres = 1;                    // in one unit of x, y and z, where the table tells it
  std::vector<size_t> velocity, rate;   // three each, or none: v_world, omega_body
};

/// By the names over the columns, which may be a comment's: t, time or timestamp; x y z, tx, px,
/// p_RS_R_x, pose.position.x and their like; qx qy qz qw in any order; vx_world .. wz_body or
/// vx .. wz. Without names by the number of columns: 8 as TUM's, 9 with a running number ahead, 17
/// as EuRoC's state_groundtruth (w first), 20 as OpenVINS' with covariances. Errors name what is
/// missing and what is there.
Result<TrajectoryColumns> FindTrajectoryColumns(const TextGrid& grid, const std::string& path);

}  // namespace tagtwist::internal
