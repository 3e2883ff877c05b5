#pragma once
#include <Eigen/Core>
#include <vector>

#include "frontend/simulation/scene.h"
#include "frontend/types/camera.h"

namespace tagtwist::internal {

/// Rays of a supersampled image: `per_pixel` x `per_pixel` samples a pixel, spread evenly over its
/// square (pixel centres at integers), over the image and `padding_px` pixels around it.
struct SampleGrid {
  SampleGrid(const Camera& camera, int per_pixel, int padding_px);

  int per_pixel = 1, padding_px = 0;
  int width = 0, height = 0;  // in samples
  Camera camera;
  /// Normalised image coordinates of every sample, row by row; NaN where the lens has no ray.
  std::vector<float> x, y;
  float x_min = 0, x_max = 0, y_min = 0, y_max = 0;  // their bounds
};

/// What each sample sees: its grey, and the inverse depth [1/m] of what it sees (0: nothing yet).
struct SampleImage {
  std::vector<float> grey, inverse_depth;
  void Reset(const SampleGrid& grid, double background_grey);
};

/// Fills the plane z = 0 of W, which must come before everything on it.
void PaintFloor(const SampleGrid& grid, const Pose& cam_from_world, double grey,
                SampleImage* image);

struct PaintGreys {
  float white = 225, black = 25;  // of the cells of a tag
};

/// Paints a patch where it is nearer than, or in the plane of, what is there. Every sample takes
/// the mean grey over its own footprint, so that edges lie exactly where they project to. The blend
/// at a patch's outline needs what lies behind to be painted first.
void PaintPatch(const SampleGrid& grid, const Pose& cam_from_world, const Patch& patch,
                const PaintGreys& greys, SampleImage* image);

}  // namespace tagtwist::internal
