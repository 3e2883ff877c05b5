#pragma once
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estimator/jobs/run_options.h"
#include "estimator/jobs/run_result.h"
#include "estimator/online/config.h"
#include "estimator/result/estimate.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What a state was made from.
struct OnlineFrame {
  cv::Mat image;                        // 8-bit gray; empty: none was read
  std::vector<TagDetection> tags;       // as they were seen
  std::vector<int> used_tags;           // ids of those that the state was made with
  std::vector<double> reprojection_px;  // distances of their corners from where the state has them
  double age_ms = 0;                    // of the frame when its state was known, where it is live
  size_t frames_dropped = 0;            // until then, where it is live
};

/// OnlineEstimator over a recording, state by state: ask for one after the other, then for the
/// whole run. With full detection and several threads, images are searched ahead.
class OnlineRun {
 public:
  /// `source` must outlive it.
  static Result<OnlineRun> Create(const std::string& dataset, DataSource* source,
                                  const Config& config, const RunOptions& options);
  OnlineRun(OnlineRun&&) noexcept;
  OnlineRun& operator=(OnlineRun&&) noexcept;
  ~OnlineRun();

  /// The next frame's state as soon as it is known, until the next call; nullptr at the end.
  Result<const FrameEstimate*> Next();
  /// What that state was made from, until the next call.
  const OnlineFrame& frame() const;
  /// All of the run, after the end. An error when no frame has a usable tag.
  Result<RunResult> Finish();

 private:
  struct Impl;
  explicit OnlineRun(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist::internal
