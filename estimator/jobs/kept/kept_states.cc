#include "estimator/jobs/kept/kept_states.h"

#include <algorithm>
#include <memory>
#include <utility>

namespace tagtwist::internal {

KeptFrames::KeptFrames(size_t most) : frames_(most), lagged_(most), reprojection_px_(most) {}

void KeptFrames::Add(const FrameEstimate& frame, const std::vector<double>& reprojection_px) {
  all_.frames.Add(frame);
  frames_.Add(frame);
  reprojection_px_.Add(reprojection_px);
}

void KeptFrames::AddLagged(const FrameEstimate& frame) {
  all_.lagged.Add(frame);
  lagged_.Add(frame);
}

bool KeptFrames::HasFix() const { return all_.frames.with_state > 0 || all_.lagged.with_state > 0; }

std::shared_ptr<const RunTally> KeptFrames::MoveTo(Estimate* estimate) {
  estimate->frames = frames_.Take();
  estimate->lagged = lagged_.Take();
  for (const std::vector<double>& px : reprojection_px_.values()) {
    estimate->reprojection_px.insert(estimate->reprojection_px.end(), px.begin(), px.end());
  }
  return frames_.stride() > 1 ? std::make_shared<const RunTally>(std::move(all_)) : nullptr;
}

void KeptTimes::Stage::Add(const std::vector<double>& ms) {
  for (const double x : ms) {
    some.Add(x);
    ++all.count;
    all.sum_ms += x;
    all.max_ms = std::max(all.max_ms, x);
  }
}

KeptTimes::KeptTimes(size_t most, std::optional<double> deadline_ms)
    : deadline_ms_(deadline_ms),
      detect_(most),
      track_(most),
      seed_(most),
      optimise_(most),
      frame_(most),
      latency_(most) {}

void KeptTimes::Add(const StageTimes& of_frame) {
  detect_.Add(of_frame.detect_ms);
  track_.Add(of_frame.track_ms);
  seed_.Add(of_frame.seed_ms);
  optimise_.Add(of_frame.optimise_ms);
  frame_.Add(of_frame.frame_ms);
  for (const double ms : of_frame.frame_ms) {
    if (deadline_ms_ && ms > *deadline_ms_) ++frames_late_;
  }
}

void KeptTimes::AddLatency(double ms) { latency_.Add({ms}); }

void KeptTimes::MoveTo(RunFacts* facts) {
  if (frame_.some.stride() > 1) {
    facts->totals = {detect_.all, track_.all, seed_.all, optimise_.all, frame_.all, frames_late_};
    if (facts->live) facts->live->total = latency_.all;
  }
  facts->times = {detect_.some.Take(), track_.some.Take(), seed_.some.Take(), optimise_.some.Take(),
                  frame_.some.Take()};
  if (facts->live) facts->live->latency_ms = latency_.some.Take();
}

}  // namespace tagtwist::internal
