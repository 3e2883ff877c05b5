#include "frontend/simulation/image_optics.h"

#include <cmath>
#include <numeric>

namespace tagtwist::internal {
namespace {

// The vertical pass: one row of sums, `per_pixel + 2 reach` sample rows weighted, columns kept.
void SumRows(const SampleGrid& grid, const std::vector<float>& samples, const PixelKernel& kernel,
             int pixel_row, std::vector<float>* sums) {
  const auto width = static_cast<size_t>(grid.width);
  sums->assign(width, 0.0F);
  const int first = (pixel_row + grid.padding_px) * grid.per_pixel - kernel.reach;
  for (size_t k = 0; k < kernel.weights.size(); ++k) {
    const float weight = kernel.weights[k];
    const float* row = samples.data() + (static_cast<size_t>(first) + k) * width;
    float* sum = sums->data();
    for (size_t i = 0; i < width; ++i) sum[i] += weight * row[i];
  }
}

}  // namespace

PixelKernel::PixelKernel(int per_pixel, double blur_px) {
  const double sigma = blur_px * per_pixel;  // in samples
  reach = static_cast<int>(std::ceil(4 * sigma));
  std::vector<double> gaussian;
  for (int k = -reach; k <= reach; ++k) {
    gaussian.push_back(reach == 0 ? 1.0 : std::exp(-0.5 * (k / sigma) * (k / sigma)));
  }
  const double total = std::accumulate(gaussian.begin(), gaussian.end(), 0.0) * per_pixel;
  std::vector<double> sums(static_cast<size_t>(per_pixel + 2 * reach), 0.0);
  for (size_t s = 0; s < static_cast<size_t>(per_pixel); ++s) {
    for (size_t k = 0; k < gaussian.size(); ++k) sums[s + k] += gaussian[k] / total;
  }
  weights.assign(sums.begin(), sums.end());
}

std::vector<float> Downsample(const SampleGrid& grid, const std::vector<float>& samples,
                              const PixelKernel& kernel) {
  const int width = grid.camera.width, height = grid.camera.height;
  std::vector<float> out, sums;
  out.reserve(static_cast<size_t>(width) * static_cast<size_t>(height));
  for (int row = 0; row < height; ++row) {
    SumRows(grid, samples, kernel, row, &sums);
    for (int column = 0; column < width; ++column) {
      const int first = (column + grid.padding_px) * grid.per_pixel - kernel.reach;
      out.push_back(std::inner_product(kernel.weights.begin(), kernel.weights.end(),
                                       sums.begin() + first, 0.0F));
    }
  }
  return out;
}

std::vector<float> MakeGain(const Camera& camera, double vignetting, double gradient,
                            double gradient_direction_rad) {
  const double cx = 0.5 * (camera.width - 1), cy = 0.5 * (camera.height - 1);
  const double corner2 = cx * cx + cy * cy + 1e-12;
  const double ux = std::cos(gradient_direction_rad), uy = std::sin(gradient_direction_rad);
  std::vector<float> out;
  for (int row = 0; row < camera.height; ++row) {
    for (int column = 0; column < camera.width; ++column) {
      const double x = column - cx, y = row - cy;
      const double along = ux * x / camera.width + uy * y / camera.height;
      out.push_back(static_cast<float>((1 - vignetting * (x * x + y * y) / corner2) *
                                       (1 + gradient * along)));
    }
  }
  return out;
}

}  // namespace tagtwist::internal
