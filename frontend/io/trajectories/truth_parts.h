#pragma once
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/tables/csv.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// Pieces that the readers of ground truth share.

/// Pose from [x y z qx qy qz qw]; the fault ("quaternion: expected unit norm, got 0.5") otherwise.
Result<Pose> PoseFromNumbers(const std::vector<double>& xyz_qxyzw);

/// Ground truth of an EuRoC/ASL table (state_groundtruth_estimate0). The rate is that of the
/// columns w_RS_S_* where it has them (an addition of this project's writer), else the gyro's less
/// the table's bias at the nearest sample within 10 ms, else the attitudes' difference.
Result<std::vector<TruthSample>> TruthFromEurocTable(const CsvTable& table,
                                                     const std::vector<ImuSample>& imu,
                                                     std::vector<std::string>* notes = nullptr);
bool LooksLikeEurocTruth(const CsvTable& table);
std::string FormatEurocTruth(const std::vector<TruthSample>& truth);

/// True where there are samples and every one has a twist.
bool AllHaveTwist(const std::vector<TruthSample>& truth);

}  // namespace tagtwist::internal
