#pragma once
#include <memory>
#include <string>
#include <vector>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/run_options.h"
#include "estimator/jobs/run_result.h"
#include "estimator/online/config.h"
#include "estimator/result/estimate.h"
#include "estimator/result/seen_body.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// All that is known of a frame.
struct OnlineFrame {
  std::vector<CameraImage> images;  // of the cameras that took it, ascending
  std::vector<SeenBody> bodies;     // set_up's, then Config::bodies
  double age_ms = 0;                // of the frame when its state was known, where it is live
  size_t frames_dropped = 0;        // until then, where it is live
};

/// Names of OnlineFrame::bodies; "body" where the configuration has none.
std::vector<std::string> BodyNames(const Config& config);

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
  /// That state, those of other bodies, and what they were made from, until the next call.
  const OnlineFrame& frame() const;
  /// All of the run, after the end, of the states that RunOptions::most_kept leaves. An error when
  /// no frame has a usable tag.
  Result<RunResult> Finish();

 private:
  struct Impl;
  explicit OnlineRun(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist::internal
