#include "frontend/simulation/renderer.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "frontend/base/statistics/random_stream.h"

namespace tagtwist::internal {
namespace {

constexpr uint64_t kNoisePurpose = 3;  // of the random stream
constexpr double kMostSamples = 1e8;   // of the supersampled image

// Far ones first, for the same reason as below.
std::vector<const WallSheet*> WallsFarToNear(const std::vector<WallSheet>& walls,
                                             const Pose& cam_from_world) {
  std::vector<const WallSheet*> out;
  for (const WallSheet& wall : walls) out.push_back(&wall);
  std::stable_sort(out.begin(), out.end(), [&](const WallSheet* a, const WallSheet* b) {
    return (cam_from_world * a->sheet.centre).norm() > (cam_from_world * b->sheet.centre).norm();
  });
  return out;
}

// Far patches first: what shines through at the outline of a near one is then there already.
std::vector<const Patch*> SortFarToNear(const std::vector<Patch>& tags,
                                        const std::vector<Patch>& occluders,
                                        const Pose& cam_from_world) {
  std::vector<std::pair<double, const Patch*>> by_distance;
  for (const auto* patches : {&tags, &occluders}) {
    for (const Patch& patch : *patches) {
      by_distance.emplace_back((cam_from_world * patch.centre).norm(), &patch);
    }
  }
  std::stable_sort(by_distance.begin(), by_distance.end(),
                   [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<const Patch*> out;
  out.reserve(by_distance.size());
  for (const auto& [distance, patch] : by_distance) out.push_back(patch);
  return out;
}

}  // namespace

Result<Renderer> Renderer::Make(const Camera& camera, const TagMap& map,
                                const RendererOptions& options) {
  if (const auto problem = options.Problem()) return Error{*problem};
  if (const auto problem = camera.Problem()) return Error{"camera: " + *problem};
  const double pixels = static_cast<double>(camera.width) * camera.height;
  if (!(pixels * options.supersampling * options.supersampling <= kMostSamples)) {
    return Error{"supersampling: more than 100 million samples an image of this size"};
  }
  auto scene = Scene::Make(map, options.scene);
  if (!scene) return scene.error();
  return Renderer(std::move(*scene), camera, options);
}

Renderer::Renderer(Scene scene, const Camera& camera, const RendererOptions& options)
    : options_(options),
      scene_(std::move(scene)),
      kernel_(options.supersampling, options.blur_px),
      grid_(camera, options.supersampling, kernel_.PaddingPx(options.supersampling)),
      gain_(
          MakeGain(camera, options.vignetting, options.gradient, options.gradient_direction_rad)) {}

void Renderer::DrawScene(const Pose& world_from_cam, double t_s, bool blank_tags,
                         SampleImage* image) const {
  const SceneOptions& look = scene_.options();
  const Pose cam_from_world = Inverse(world_from_cam);
  const auto white = static_cast<float>(look.paper_grey);
  const PaintGreys greys{white, blank_tags ? white : static_cast<float>(look.ink_grey)};
  image->Reset(grid_, look.background_grey);
  if (look.floor) PaintFloor(grid_, cam_from_world, look.floor_grey, image);
  for (const Patch& patch : scene_.scribbles()) {
    PaintPatch(grid_, cam_from_world, patch, greys, image);
  }
  for (const WallSheet* wall : WallsFarToNear(scene_.walls(), cam_from_world)) {
    PaintPatch(grid_, cam_from_world, wall->sheet, greys, image);
    for (const Patch& patch : wall->scribbles) {
      PaintPatch(grid_, cam_from_world, patch, greys, image);
    }
  }
  const std::vector<Patch> occluders = scene_.OccludersAt(t_s);
  for (const Patch* patch : SortFarToNear(scene_.tags(), occluders, cam_from_world)) {
    PaintPatch(grid_, cam_from_world, *patch, greys, image);
  }
}

cv::Mat Renderer::Expose(const std::vector<float>& greys, uint64_t frame_index) const {
  cv::Mat out(grid_.camera.height, grid_.camera.width, CV_8UC1);
  RandomStream random(options_.scene.random_seed, kNoisePurpose, frame_index);
  for (size_t i = 0; i < greys.size(); ++i) {
    double grey = greys[i] * gain_[i];
    if (options_.noise_grey > 0) grey += options_.noise_grey * random.Normal();
    out.data[i] = static_cast<uint8_t>(std::clamp(std::floor(grey + 0.5), 0.0, 255.0));
  }
  return out;
}

cv::Mat Renderer::Render(const std::vector<Pose>& world_from_cam, double t_s, uint64_t frame_index,
                         bool blank_tags) const {
  SampleImage image;
  std::vector<float> sum;
  for (const Pose& pose : world_from_cam) {
    DrawScene(pose, t_s, blank_tags, &image);
    if (sum.empty()) {
      sum.swap(image.grey);
    } else {
      std::transform(sum.begin(), sum.end(), image.grey.begin(), sum.begin(), std::plus<>());
    }
  }
  std::vector<float> greys = Downsample(grid_, sum, kernel_);
  const float share = 1.0F / static_cast<float>(world_from_cam.size());
  for (float& grey : greys) grey *= share;
  return Expose(greys, frame_index);
}

}  // namespace tagtwist::internal
