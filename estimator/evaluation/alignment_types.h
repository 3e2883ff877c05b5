#pragma once
#include <optional>
#include <string>

#include "frontend/types/pose.h"

namespace tagtwist {

enum class AlignmentKind {
  kNone,
  kSe3,      // the estimate's world moved rigidly onto the truth's, positions least squares
  kHandEye,  // the same, and a rigid transform between the estimated body and the truth's marker
};
const char* ToString(AlignmentKind kind);  // "none", "se3", "handeye"
std::optional<AlignmentKind> ParseAlignmentKind(const std::string& name);

/// Standard deviations of an alignment: of poses in their tangents (pose.h), [rad; m]; 0: held.
struct AlignmentSigmas {
  Eigen::Matrix<double, 6, 1> truth_from_world = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::Matrix<double, 6, 1> body_from_marker = Eigen::Matrix<double, 6, 1>::Zero();
  double time_offset_s = 0;
  bool Any() const { return body_from_marker(0) > 0; }
};

/// truth(stamp + time_offset_s) ~ truth_from_world * world_from_body * body_from_marker.
struct Alignment {
  Pose truth_from_world;
  Pose body_from_marker;
  double time_offset_s = 0;
  AlignmentSigmas sigmas;  // of a hand-eye alignment
};

struct AlignmentOptions {
  AlignmentKind kind = AlignmentKind::kNone;
  double time_offset_s = 0;           // where it is not estimated
  bool estimate_time_offset = false;  // searched in time_offset_s +- max_time_offset_s
  double max_time_offset_s = 0.5;     // [s], > 0
  double max_truth_gap_s = 0.1;       // see InterpolateTruth
};

}  // namespace tagtwist
