#include "estimator/window/fixed_lag_smoother.h"

#include <algorithm>
#include <utility>

#include "estimator/graph/reprojection.h"
#include "estimator/start/mirror.h"

namespace tagtwist::internal {
FixedLagSmoother::FixedLagSmoother(EstimatorSetup setup)
    : setup_(std::move(setup)),
      set_up_check_(setup_),
      gate_(setup_.map, setup_.Cameras()),
      noise_(InitialNoise(setup_.options)),
      segmenter_({setup_.options.max_tracks_per_frame, setup_.options.track_segment_frames}),
      reprojection_(setup_) {}

Result<WindowOutput> FixedLagSmoother::Add(const FrameMeasurements& given, const TimeUp& time_up) {
  WindowOutput out;
  FrameMeasurements measurement = given;
  repeated_.TakeOut(&measurement);
  LeaveOutDoubled(&measurement, &out);
  if (const auto fine = set_up_check_.Add(measurement.tags); !fine) return fine.error();
  const std::vector<TagDetection> all_tags = measurement.tags;
  JudgeByShape(&measurement.tags);
  Unseen unseen{measurement.t_ns, measurement.closed_form,
                static_cast<int>(measurement.tracks.size())};
  if (ComesTooSoon(measurement.t_ns, &out)) {
    unseen.pose = PoseOutOfTime(measurement);
    unseen.open_s = stamps_.UsualS();
    AddUnseen(unseen, measurement, &out);
    return out;
  }
  FrameStarts starts = Start(measurement, &out);
  const bool sees = !measurement.tracks.empty() && setup_.options.use_tracks;
  if (starts.starts.empty() || (starts.starts[0].tags.empty() && !sees)) {
    unseen.elsewhere = starts.excluded;
    AddUnseen(unseen, measurement, &out);
    return out;
  }
  if (!Solve(measurement, starts, time_up)) {
    StartAnew(measurement.t_ns, &out);
    starts = StartFrame(setup_, noise_, measurement, nullptr, std::nullopt);
    if (starts.starts.empty() || !Solve(measurement, starts, time_up)) {
      out.current = WithoutState(measurement);
      out.lagged.push_back(out.current);
      return out;
    }
  }
  seen_.back().tags = all_tags;
  if (seen_.size() > 1) {  // what tags said elsewhere was nothing
    for (Unseen& before : seen_[seen_.size() - 2].after) before.elsewhere.reset();
  }
  if (++frames_since_restart_ > kFramesToSettle) restarts_in_a_row_ = 0;
  JudgeIds(measurement);
  if (IsDoubted(hypotheses_[0].input.frames.back())) seen_.back().is_doubted = true;
  const bool hurried = measurement.cut_short || IsUp(time_up);
  CompareWithMirroredPoses();
  const int newest = static_cast<int>(seen_.size()) - 1;
  out.current = EstimateOf(newest);
  if (IsSudden(out.current)) ForgetTwist(&out.current);
  out.used_tags.reserve(hypotheses_[0].input.frames.back().tags.size());
  for (const TagDetection& tag : hypotheses_[0].input.frames.back().tags) {
    out.used_tags.push_back(tag.id);
  }
  if (hurried && out.current.status == FrameStatus::kOk) {
    out.current.status = FrameStatus::kHurried;
  }
  if (out.current.status != FrameStatus::kNoFix) {
    out.reprojection_px = ReprojectionErrors(setup_, hypotheses_[0].input.frames.back());
  }
  if (newest + 1 == setup_.options.window_frames) {
    LetTheOldestLeave(&out.lagged);
  }
  return out;
}

// Without those that can be none or that others contradict, and wider where they scatter.
void FixedLagSmoother::JudgeByShape(std::vector<TagDetection>* tags) {
  doubled_.TakeOutAside(tags);
  gate_.TakeRefused(tags, &misfits_px_);
  if (!IsJudgedByShape(setup_, *tags)) misfits_px_.clear();
  scatter_.Widen(scatter_.Add(misfits_px_), misfits_px_, tags);
}

// False, and the window without this frame, where that has no solution.
bool FixedLagSmoother::Solve(const FrameMeasurements& measurement, const FrameStarts& starts,
                             const TimeUp& time_up) {
  const NoiseModel noise = noise_;
  segmenter_.Add(measurement.tracks, static_cast<int>(measurement.tags.size()),
                 measurement.cameras);
  AddFrame(measurement, starts);
  if (SolveAll(time_up)) return true;
  noise_ = noise;
  seen_.pop_back();
  for (WindowHypothesis& hypothesis : hypotheses_) hypothesis.input.frames.pop_back();
  if (seen_.empty()) hypotheses_.clear();
  segmenter_.DropBefore(++first_frame_);
  return false;
}

void FixedLagSmoother::AddFrame(const FrameMeasurements& measurement, const FrameStarts& starts) {
  seen_.push_back({measurement.closed_form,
                   static_cast<int>(measurement.tracks.size()),
                   measurement.tags,
                   {},
                   false,
                   false});
  if (hypotheses_.size() > 1) {  // each goes on by itself
    for (WindowHypothesis& hypothesis : hypotheses_) {
      std::vector<GraphFrame>& frames = hypothesis.input.frames;
      const FrameStarts own = StartFrame(setup_, noise_, measurement, &frames.back(), std::nullopt);
      frames.push_back(own.starts.front());
    }
    FollowMotion();
    return;
  }
  constexpr size_t kMost = 3;
  if (hypotheses_.empty()) {
    hypotheses_.emplace_back();
    hypotheses_[0].motion = MotionHistory(noise_);
  }
  const size_t n = std::min(kMost, starts.starts.size());
  while (hypotheses_.size() < n) hypotheses_.push_back(hypotheses_.front());
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    hypotheses_[i].input.frames.push_back(starts.starts[i]);
  }
  FollowMotion();
}

void FixedLagSmoother::CompareWithMirroredPoses() {
  if (!mirror_is_open_) return;
  double cost = mirror_cost_of_left_;
  mirror_angle_rad_ = 0;
  for (const GraphFrame& frame : hypotheses_.front().input.frames) {
    const auto mirror = MirrorOf(setup_, noise_, frame);
    if (!mirror) continue;
    cost += mirror->cost;
    mirror_angle_rad_ = std::max(mirror_angle_rad_, mirror->angle_rad);
  }
  mirror_is_open_ = cost < kDecidedCost;
}

void FixedLagSmoother::LetTheOldestLeave(std::vector<FrameEstimate>* lagged) {
  LookForOpenMotion(/*at_all=*/false);
  Tell(0, lagged);
  LearnFromLeavingState();
  LearnWhatIsNotFollowed();
  if (mirror_is_open_) {
    const auto mirror = MirrorOf(setup_, noise_, hypotheses_.front().input.frames.front());
    if (mirror) mirror_cost_of_left_ += mirror->cost;
  }
  Forget(1);
  for (WindowHypothesis& hypothesis : hypotheses_) MarginalizeOldest(&hypothesis);
}

// The first frames are out of the window; what they saw is taken note of.
void FixedLagSmoother::Forget(size_t n_frames) {
  for (size_t i = 0; i < n_frames; ++i) {
    const GraphFrame& frame = hypotheses_.front().input.frames[i];
    audit_.Add(setup_, frame, seen_[i].tags);
    reprojection_.AddSeen(seen_[i].tags);
    reprojection_.AddSolved(setup_, frame);
    if (!frame.tags.empty()) last_tag_ns_ = frame.t_ns;
  }
  seen_.erase(seen_.begin(), seen_.begin() + static_cast<std::ptrdiff_t>(n_frames));
  first_frame_ += static_cast<int>(n_frames);
  segmenter_.DropBefore(first_frame_);
  open_motion_.Forget(static_cast<int>(n_frames));
}

std::vector<std::string> FixedLagSmoother::Warnings() const {
  std::vector<std::string> out = doubled_.Warnings();
  for (std::string& warning : audit_.Warnings()) out.push_back(std::move(warning));
  for (std::string& warning : doubled_.AsideWarnings()) out.push_back(std::move(warning));
  if (const auto of_tracks = segmenter_.tally().Warning()) out.push_back(*of_tracks);
  if (const auto of_stamps = stamps_.Warning()) out.push_back(*of_stamps);
  if (const auto of_repeated = repeated_.Warning()) out.push_back(*of_repeated);
  if (const auto of_restarts = RestartWarning()) out.push_back(*of_restarts);
  return out;
}

std::vector<FrameEstimate> FixedLagSmoother::Finish() {
  if (hypotheses_.empty()) return {};
  // The last step stopped where it was good enough for a new frame; this one may take its time.
  const SolveOptions options{setup_.options.max_iterations};
  for (WindowHypothesis& hypothesis : hypotheses_) {
    // An error leaves the last step's solution.
    static_cast<void>(SolveHypothesis(setup_, noise_, options, &hypothesis));
  }
  Prune(&hypotheses_);
  std::vector<FrameEstimate> out = EstimatesOfAll();
  Forget(seen_.size());
  hypotheses_.clear();
  return out;
}

}  // namespace tagtwist::internal
