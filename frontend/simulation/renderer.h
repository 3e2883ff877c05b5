#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "frontend/simulation/image_optics.h"
#include "frontend/simulation/rasteriser.h"
#include "frontend/simulation/renderer_options.h"
#include "frontend/simulation/scene.h"

namespace tagtwist::internal {

/// Draws what the camera sees of a scene. Immutable: Render may be called from several threads, and
/// its bytes depend on its arguments and the options alone.
class Renderer {
 public:
  static Result<Renderer> Make(const Camera& camera, const TagMap& map,
                               const RendererOptions& options);

  /// The image, 8-bit gray, of an exposure during which the camera took the given poses, evenly
  /// spaced in time (one pose: no motion blur); t_s places the moving occluders and frame_index
  /// picks the sensor noise. `blank_tags`: the tags' papers are empty.
  cv::Mat Render(const std::vector<Pose>& world_from_cam, double t_s, uint64_t frame_index,
                 bool blank_tags = false) const;

  const Scene& scene() const { return scene_; }
  const Camera& camera() const { return grid_.camera; }
  const RendererOptions& options() const { return options_; }

 private:
  Renderer(Scene scene, const Camera& camera, const RendererOptions& options);
  void DrawScene(const Pose& world_from_cam, double t_s, bool blank_tags, SampleImage* image) const;
  cv::Mat Expose(const std::vector<float>& greys, uint64_t frame_index) const;

  RendererOptions options_;
  Scene scene_;
  PixelKernel kernel_;
  SampleGrid grid_;
  std::vector<float> gain_;
};

}  // namespace tagtwist::internal
