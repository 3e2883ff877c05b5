#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/trajectories/trajectory_rows.h"
#include "frontend/types/body_state.h"
#include "frontend/types/truth.h"

namespace tagtwist {

/// A trajectory from a file, told apart by its content: a course .mat (time and vicon), or a text
/// in any form that ReadTrajectoryText knows. Body in W; stamps grow strictly; quaternions within
/// 1e-2 of unit norm are normalised. At least one sample. `body`: which one, where there are
/// several.
Result<TrajectoryFile> ReadTrajectoryFile(const std::string& path, const std::string& body,
                                          const Limits& limits = {});

/// Its samples, for whoever has nobody to tell the notes to.
Result<std::vector<TruthSample>> ReadGroundTruth(const std::string& path,
                                                 const Limits& limits = {});

/// The project's CSV; twist columns only where every sample has a twist.
std::string FormatGroundTruthCsv(const std::vector<TruthSample>& truth);

/// TUM lines, nine decimals of time, the shortest numbers that read back. FormatTum writes a whole
/// file with the comment that names the columns.
std::string FormatTumLine(int64_t t_ns, const Pose& world_from_body);
std::string FormatTum(const std::vector<TruthSample>& trajectory);

}  // namespace tagtwist
