#include "frontend/flow/klt_options.h"

#include <limits>

#include "frontend/base/option_check.h"

namespace tagtwist {

using namespace internal;

std::optional<std::string> KltOptions::Problem() const {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (auto& problem : {CheckRange("max_points", max_points, 0, 100000),
                        CheckRange("min_distance_px", min_distance_px, 1, kInf),
                        CheckRange("fast_threshold", fast_threshold, 1, 254),
                        CheckRange("min_fast_threshold", min_fast_threshold, 1, 254),
                        CheckRange("window_px", window_px, 5, 61),
                        CheckRange("pyramid_levels", pyramid_levels, 0, 8),
                        CheckRange("max_iterations", max_iterations, 1, 100),
                        CheckPositive("convergence_px", convergence_px),
                        CheckPositive("forward_backward_px", forward_backward_px),
                        CheckPositive("max_difference", max_difference),
                        CheckRange("border_px", border_px, 0, kInf),
                        CheckRange("enough_tags", enough_tags, 0, kInf),
                        CheckRange("tag_margin", tag_margin, 0, kInf)}) {
    if (problem) return problem;
  }
  if (window_px % 2 == 0) return "window_px: expected odd, got " + std::to_string(window_px);
  if (min_fast_threshold > fast_threshold) {
    return "min_fast_threshold: expected <= fast_threshold (" + std::to_string(fast_threshold) +
           "), got " + std::to_string(min_fast_threshold);
  }
  return std::nullopt;
}

}  // namespace tagtwist
