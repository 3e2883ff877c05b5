#include "frontend/simulation/renderer_options.h"

#include <limits>

#include "frontend/base/option_check.h"

namespace tagtwist {

using namespace internal;

std::optional<std::string> SceneOptions::Problem() const {
  const double inf = std::numeric_limits<double>::infinity();
  for (const auto& problem :
       {CheckRange("paper_grey", paper_grey, 0, 255), CheckRange("ink_grey", ink_grey, 0, 255),
        CheckRange("floor_grey", floor_grey, 0, 255),
        CheckRange("background_grey", background_grey, 0, 255),
        CheckRange("scribbles_per_m2", scribbles_per_m2, 0, 1e4),
        CheckRange("occluders", occluders, 0, 1000),
        CheckPositive("occluder_radius_m", occluder_radius_m),
        CheckRange("occluder_height_m", occluder_height_m, 0, inf),
        CheckRange("occluder_speed_mps", occluder_speed_mps, 0, inf)}) {
    if (problem) return problem;
  }
  return std::nullopt;
}

std::optional<std::string> RendererOptions::Problem() const {
  for (const auto& problem :
       {scene.Problem(), CheckRange("supersampling", supersampling, 1, 16),
        CheckRange("blur_px", blur_px, 0, 20), CheckRange("vignetting", vignetting, 0, 1),
        CheckRange("gradient", gradient, 0, 1),
        CheckRange("gradient_direction_rad", gradient_direction_rad, -7, 7),
        CheckRange("noise_grey", noise_grey, 0, 255)}) {
    if (problem) return problem;
  }
  return std::nullopt;
}

}  // namespace tagtwist
