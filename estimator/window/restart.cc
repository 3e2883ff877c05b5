#include <string>

#include "estimator/solve/noise_learning.h"
#include "estimator/solve/smoother.h"
#include "estimator/window/fixed_lag_smoother.h"
#include "frontend/base/format_text.h"

namespace tagtwist {

void FixedLagSmoother::Break() {
  Forget(seen_.size());
  hypotheses_.clear();
  power_.Break();
  mirror_is_open_ = true;
  mirror_cost_of_left_ = 0;
}

bool FixedLagSmoother::StartAnew(const FrameMeasurements& measurement,
                                 const std::vector<TagDetection>& all_tags, const TimeUp& time_up,
                                 WindowOutput* out) {
  const auto forget_newest = [this] {
    seen_.pop_back();
    for (WindowHypothesis& hypothesis : hypotheses_) hypothesis.input.frames.pop_back();
  };
  forget_newest();
  out->lagged.insert(out->lagged.end(), told_.begin(), told_.end());
  Break();
  noise_ = InitialNoise(setup_.options);
  statistics_ = {};
  has_learned_ = false;
  frames_of_learning_ = 0;
  restarts_ns_.push_back(measurement.t_ns);
  const FrameStarts starts = StartFrame(setup_, noise_, measurement, nullptr, std::nullopt);
  if (!starts.starts.empty()) {
    AddFrame(measurement, starts);
    seen_.back().tags = all_tags;
    if (SolveAll(time_up)) return true;
    forget_newest();
    hypotheses_.clear();
  }
  segmenter_.DropBefore(++first_frame_);
  out->current = WithoutState(measurement);
  out->lagged.push_back(out->current);
  return false;
}

std::optional<std::string> FixedLagSmoother::RestartWarning() const {
  if (restarts_ns_.empty()) return std::nullopt;
  return Format("the window had no solution and was started anew %zu time%s, first at %.3f s",
                restarts_ns_.size(), restarts_ns_.size() == 1 ? "" : "s",
                ToSeconds(restarts_ns_.front()));
}

}  // namespace tagtwist
