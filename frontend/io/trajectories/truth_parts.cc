#include "frontend/io/trajectories/truth_parts.h"

#include <cmath>

#include "frontend/base/number_text.h"

namespace tagtwist::internal {

Result<Pose> PoseFromNumbers(const std::vector<double>& xyz_qxyzw) {
  const std::vector<double>& n = xyz_qxyzw;
  const Eigen::Quaterniond rotation(n[6], n[3], n[4], n[5]);
  const double norm = rotation.norm();
  if (!(std::abs(norm - 1) <= 1e-2)) {
    return Error{"quaternion: expected unit norm, got " + FormatNumber(norm) +
                 " (are these its columns? docs/formats.md has their order, and the names of a "
                 "header line)"};
  }
  return MakePose(rotation.normalized(), {n[0], n[1], n[2]});
}

bool AllHaveTwist(const std::vector<TruthSample>& truth) {
  for (const TruthSample& sample : truth) {
    if (!sample.twist) return false;
  }
  return !truth.empty();
}

}  // namespace tagtwist::internal
