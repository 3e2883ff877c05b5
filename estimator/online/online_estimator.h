#pragma once
#include <cstdint>
#include <memory>
#include <vector>

#include "estimator/online/camera_image.h"
#include "estimator/online/config.h"
#include "estimator/online/online_options.h"
#include "estimator/window/sliding_window.h"
#include "frontend/base/result.h"
#include "frontend/types/measurements.h"

namespace cv {
class Mat;
}

namespace tagtwist {

/// Images in, states out, one frame after another: tags found where the window predicts them,
/// tracks, closed form, and the sliding window. It is what `tagtwist_estimate --sliding_window`
/// runs, which adds a recording, a clock, and threads that search images ahead.
class OnlineEstimator {
 public:
  /// An error: the map's family or ids are unknown.
  static Result<OnlineEstimator> Create(const Config& config, const OnlineOptions& options = {});
  OnlineEstimator(OnlineEstimator&&) noexcept;
  OnlineEstimator& operator=(OnlineEstimator&&) noexcept;
  ~OnlineEstimator();

  /// Whether AddImage finds tags where the window predicts them.
  bool is_guided() const;

  /// The next frame from its image: 8-bit gray, of the camera's size, or empty (no image, or a bad
  /// one); of a rig that of the first camera. An error: stamps that do not grow, another size, a
  /// problem that cannot be solved; after the last one no frame may follow.
  Result<WindowOutput> AddImage(int64_t t_ns, const cv::Mat& gray);
  /// The same from the images that cameras of a rig took at that time, by the body's clock: one of
  /// them or several, ascending. Each camera's tags are found where the window's prediction of the
  /// body puts them through its mount.
  Result<WindowOutput> AddImages(int64_t t_ns, const std::vector<CameraImage>& images);
  /// The next frame from tags that were detected elsewhere, without those that FilterTags drops.
  /// Errors as of AddImage.
  Result<WindowOutput> AddTags(int64_t t_ns, const std::vector<TagDetection>& tags);
  /// The same, and tracks from the frame's image, of a rig the first camera's.
  Result<WindowOutput> AddTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                               const cv::Mat& gray);
  /// The next frame, measured elsewhere. Errors as of AddImage.
  Result<WindowOutput> AddMeasurements(FrameMeasurements measurements);

  /// What was measured in the last frame.
  const FrameMeasurements& measurements() const;
  /// The frames still in the window, smoothed; call at the end.
  std::vector<FrameEstimate> Finish();
  /// With OnlineOptions::use_imu: what it said since the last call, those around a frame before it.
  void AddImu(const std::vector<ImuSample>& samples);
  const SlidingWindow& window() const;

 private:
  struct Impl;
  explicit OnlineEstimator(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist
