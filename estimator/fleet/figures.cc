#include "estimator/fleet/figures.h"

#include <cstring>
#include <string>

#include "frontend/base/check.h"

namespace tagtwist::internal {

const std::vector<Figure>& Figures() {
  using Worse = Figure::Worse;
  constexpr double kDegrees = 57.295779513082323;
  static const std::vector<Figure> figures = {
      {"position_rmse_m", "/accuracy/optimised/position_rmse_m", "ATE", "mm", 1e3, Worse::kLarger},
      {"rotation_rmse_rad", "/accuracy/optimised/rotation_rmse_rad", "ATE", "deg", kDegrees,
       Worse::kLarger},
      {"rpe_time_m", "/accuracy/optimised/rpe_time/translation_rmse_m", "RPE 1 s", "mm", 1e3,
       Worse::kLarger},
      {"velocity_rmse_mps", "/accuracy/optimised/velocity_rmse_mps", "velocity", "mm/s", 1e3,
       Worse::kLarger},
      {"rate_rmse_radps", "/accuracy/optimised/rate_rmse_radps", "rates", "mrad/s", 1e3,
       Worse::kLarger},
      {"nees_per_dof", "/accuracy/optimised/nees/per_dof", "NEES", "per dof", 1,
       Worse::kFurtherFromOne},
      {"bound_position_m", "/bound/smoothed/position_m", "bound", "mm", 1e3, Worse::kLarger},
      {"bound_rotation_rad", "/bound/smoothed/rotation_rad", "bound", "deg", kDegrees,
       Worse::kLarger},
      {"position_rmse_over_bound", "/bound/rmse_over_bound/position", "ATE/bound", "", 1,
       Worse::kLarger},
      {"reprojection_median_px", "/reprojection_px/median", "reprojection", "px", 1,
       Worse::kLarger},
      {"corner_sigma_px", "/noise/corner_sigma_px", "corner noise", "px", 1, Worse::kLarger},
      {"wall_s", "/wall_s", "time", "s", 1, Worse::kNone},
      {"peak_rss_mib", "/peak_rss_mib", "memory", "MiB", 1, Worse::kNone}};
  return figures;
}

size_t FigureIndex(const char* key) {
  const std::vector<Figure>& figures = Figures();
  for (size_t i = 0; i < figures.size(); ++i) {
    if (std::strcmp(figures[i].key, key) == 0) return i;
  }
  TAGTWIST_CHECK(false, std::string("a figure that there is, not ") + key);
  return 0;
}

}  // namespace tagtwist::internal
