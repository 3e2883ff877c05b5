#include "frontend/pose_seed.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

#include "frontend/homography.h"
#include "frontend/option_check.h"
#include "frontend/tag_planes.h"
#include "frontend/types/so3.h"

namespace tagtwist {
std::optional<std::string> PoseSeedOptions::Problem() const { return std::nullopt; }
PoseSeed SeedPose(const std::vector<TagDetection>& tags, const TagMap&, const Camera&, const Pose&,
                  const PoseSeedOptions&) {
  PoseSeed seed;
  seed.tag_inlier.assign(tags.size(), false);
  return seed;
}
}  // namespace tagtwist
