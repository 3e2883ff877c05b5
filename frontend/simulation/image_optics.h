#pragma once
#include <vector>

#include "frontend/simulation/rasteriser.h"

namespace tagtwist::internal {

/// Weights by which the samples around a pixel make its value: the pixel's own square and a
/// Gaussian of standard deviation blur_px. The first weight belongs to the sample `reach` samples
/// before the pixel's first; they add up to 1.
struct PixelKernel {
  PixelKernel(int per_pixel, double blur_px);
  std::vector<float> weights;  // per_pixel + 2 reach of them
  int reach = 0;               // [samples]
  int PaddingPx(int per_pixel) const { return (reach + per_pixel - 1) / per_pixel; }
};

/// Greys of the camera's pixels, row by row, from the samples of a grid whose padding covers the
/// kernel's reach.
std::vector<float> Downsample(const SampleGrid& grid, const std::vector<float>& samples,
                              const PixelKernel& kernel);

/// Brightness of every pixel as a share of the scene's: 1 - vignetting (r / r_corner)^2 about the
/// image's centre, times 1 + gradient * (place along the direction, -1/2 .. 1/2 over the image).
std::vector<float> MakeGain(const Camera& camera, double vignetting, double gradient,
                            double gradient_direction_rad);

}  // namespace tagtwist::internal
