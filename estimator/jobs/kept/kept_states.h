#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "estimator/result/estimate.h"
#include "estimator/result/run_facts.h"
#include "estimator/result/run_tally.h"
#include "frontend/base/statistics/thinned_sample.h"

namespace tagtwist::internal {

/// What a run keeps of a body's states: of `most` frames.
class KeptFrames {
 public:
  explicit KeptFrames(size_t most);
  void Add(const FrameEstimate& frame, const std::vector<double>& reprojection_px);
  void AddLagged(const FrameEstimate& frame);
  /// Whether a frame has a state.
  bool HasFix() const;
  /// At the end. The tally of all, where they are more than are kept.
  std::shared_ptr<const RunTally> MoveTo(Estimate* estimate);

 private:
  RunTally all_;
  ThinnedSample<FrameEstimate> frames_, lagged_;
  ThinnedSample<std::vector<double>> reprojection_px_;  // of each frame
};

/// What a run keeps of its frames' times: of `most` frames.
class KeptTimes {
 public:
  KeptTimes(size_t most, std::optional<double> deadline_ms);
  /// Of one frame.
  void Add(const StageTimes& of_frame);
  void AddLatency(double ms);
  /// At the end.
  void MoveTo(RunFacts* facts);

 private:
  struct Stage {
    explicit Stage(size_t most) : some(most) {}
    void Add(const std::vector<double>& ms);
    ThinnedSample<double> some;
    TimeTotal all;
  };
  std::optional<double> deadline_ms_;
  Stage detect_, track_, seed_, optimise_, frame_, latency_;
  size_t frames_late_ = 0;
};

}  // namespace tagtwist::internal
