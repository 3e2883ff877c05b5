#pragma once
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "estimator/online/config.h"
#include "estimator/window/rolling_shutter.h"
#include "estimator/window/sliding_window.h"
#include "frontend/base/result.h"
#include "frontend/front_end.h"
#include "frontend/tags/tag_follower.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// Images in, states out, one frame after another: tags found where the window predicts them,
/// tracks, closed form, and the sliding window. The states are those of `tagtwist_estimate
/// --sliding_window` over the same frames. For a program of one's own; threads, deadlines and stage
/// times are put together from the parts, as estimator/jobs/run.cc does.
class OnlineEstimator {
 public:
  /// Tags are guided where the detector's options refine patterns, else each image is searched. An
  /// error: the map's family or ids are unknown.
  static Result<OnlineEstimator> Create(const Config& config);

  /// The next frame from its image: 8-bit gray, of the camera's size, or empty (no image, or a bad
  /// one). An error: stamps that do not grow, another size, a problem that cannot be solved; after
  /// the last one no frame may follow.
  Result<WindowOutput> AddImage(int64_t t_ns, const cv::Mat& gray);
  /// The next frame from tags that were detected elsewhere, without those that FilterTags drops,
  /// and from its image where there are to be tracks. Errors as of AddImage.
  Result<WindowOutput> AddTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                               const cv::Mat& gray = {});

  /// The frames still in the window, smoothed; call at the end.
  std::vector<FrameEstimate> Finish() { return window_.Finish(); }
  const SlidingWindow& window() const { return window_; }

 private:
  OnlineEstimator(const Config& config, std::optional<TagFollower> follower,
                  std::optional<TagDetector> detector);
  Result<WindowOutput> Add(int64_t t_ns, const std::vector<TagDetection>& tags,
                           const cv::Mat& gray);
  Status Check(int64_t t_ns, const cv::Mat& gray) const;

  Config config_;
  std::optional<TagFollower> follower_;  // guided,
  std::optional<TagDetector> detector_;  // or not
  FrontEnd front_end_;
  std::optional<RollingShutterUndo> undo_;  // where the camera has one
  SlidingWindow window_;
  std::optional<int64_t> last_ns_;
};

}  // namespace tagtwist
