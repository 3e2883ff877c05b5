#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/body_state.h"

namespace tagtwist {

/// Ground truth from a file, told apart by its content:
/// - CSV with columns t,x,y,z,qx,qy,qz,qw and optionally the twist vx_world,...,wz_body (or
///   vx,...,wz), in any order, among others that are ignored (so states.csv is read, too);
/// - EuRoC/ASL state_groundtruth (timestamp in ns); the rate, which it lacks, comes from the
///   attitudes' differences;
/// - TUM: "t x y z qx qy qz qw" apart by blanks, comments from '#';
/// - a course .mat (time and vicon).
/// Body in W; stamps grow strictly; quaternions within 1e-2 of unit norm are normalised. At least
/// one sample.
Result<std::vector<TruthSample>> ReadGroundTruth(const std::string& path);

/// The project's CSV; twist columns only where every sample has a twist.
std::string FormatGroundTruthCsv(const std::vector<TruthSample>& truth);

/// TUM lines, nine decimals of time, the shortest numbers that read back. FormatTum writes a whole
/// file with the comment that names the columns.
std::string FormatTumLine(int64_t t_ns, const Pose& world_from_body);
std::string FormatTum(const std::vector<TruthSample>& trajectory);

/// Body rates [rad/s, in B] by central differences of the attitudes (one-sided at the ends);
/// zero for a single sample.
std::vector<Eigen::Vector3d> DifferentiateAttitude(const std::vector<TruthSample>& truth);

}  // namespace tagtwist
