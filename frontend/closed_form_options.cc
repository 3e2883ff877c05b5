#include "frontend/closed_form_options.h"

#include <limits>

#include "frontend/base/option_check.h"

namespace tagtwist {

using namespace internal;

std::optional<std::string> ClosedFormOptions::Problem() const {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kBelowOne = 1 - 1e-15;
  for (auto& problem : {CheckPositive("max_gap_s", max_gap_s),
                        CheckRange("low_pass_alpha", low_pass_alpha, 0, kBelowOne),
                        CheckPositive("ransac_threshold_px", ransac_threshold_px),
                        CheckRange("ransac_success", ransac_success, 1e-9, kBelowOne),
                        CheckRange("ransac_inlier_ratio", ransac_inlier_ratio, 1e-3, kBelowOne),
                        CheckRange("ransac_enough_inliers", ransac_enough_inliers, 3, kInf),
                        CheckRange("ransac_seed", ransac_seed, 0, kInf)}) {
    if (problem) return problem;
  }
  return std::nullopt;
}

}  // namespace tagtwist
