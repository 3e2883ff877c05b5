#pragma once
#include <memory>
#include <string>

#include "estimator/jobs/run_options.h"
#include "estimator/jobs/run_result.h"
#include "estimator/online/config.h"
#include "estimator/result/estimate.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

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
  /// All of the run, after the end. An error when no frame has a usable tag.
  Result<RunResult> Finish();

 private:
  struct Impl;
  explicit OnlineRun(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist::internal
