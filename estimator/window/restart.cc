// Where a new frame starts, and where it has nothing to do with those before.
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "estimator/start/leaps.h"
#include "estimator/window/fixed_lag_smoother.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// As IsWithinReach, but beyond what the tags' own uncertainty may make of it.
bool IsOutOfReach(const Pose& from, const PoseMeasurement& to, double dt_s) {
  constexpr double kSigmas = 6;
  PoseStep nearest = Difference(to.world_from_body, from);
  for (int part = 0; part < 6; part += 3) {
    const double sigma =
        std::sqrt((part == 0 ? to.attitude_covariance : to.position_covariance).trace());
    const double size = nearest.segment<3>(part).norm();
    nearest.segment<3>(part) *= std::max(0.0, size - kSigmas * sigma) / std::max(size, 1e-9);
  }
  return !IsWithinReach(from, Retract(from, nearest), dt_s);
}

// Of a window's frames the first after its latest gap.
size_t FirstSinceGap(const std::vector<GraphFrame>& frames) {
  constexpr double kGapS = 0.2;
  size_t k = frames.size() - 1;
  while (k > 0 && ToSeconds(frames[k].t_ns - frames[k - 1].t_ns) <= kGapS) --k;
  return k;
}

}  // namespace

// Where the new frame starts; where it cannot follow from those before, the window has been left.
FrameStarts FixedLagSmoother::Start(const FrameMeasurements& measurement, WindowOutput* out) {
  // Fewer frames know too little of the motion to exclude a pose.
  constexpr size_t kFramesToRelyOn = 5;
  std::optional<StateAndCovariance> predicted;
  if (seen_.size() >= kFramesToRelyOn) predicted = PredictAt(measurement.t_ns);
  const GraphFrame* last = hypotheses_.empty() ? nullptr : &hypotheses_[0].input.frames.back();
  FrameStarts starts = StartFrame(setup_, noise_, measurement, last, predicted);
  if (predicted) TakeOutranking(measurement, &starts);
  if (IsLeap(measurement, starts)) {
    starts.excluded = starts.starts[0].state.world_from_body;
    starts.starts[0].state = last->state;
    starts.starts[0].tags.clear();
  }
  const bool is_elsewhere = other_place_.Add(starts.excluded, measurement);
  if (is_elsewhere || IsBreak(measurement, starts)) {
    StartAnew(measurement.t_ns, out);
    if (is_elsewhere && measurement.tags.size() == 1 && doubled_.any_agreed()) {
      alone_since_restart_ = measurement.tags[0].id;
    }
    starts = StartFrame(setup_, noise_, measurement, nullptr, std::nullopt);
  }
  return starts;
}

// Tags that agree with one another are not set aside for what was predicted; others need more than
// one frame that tells another place (OtherPlace).
void FixedLagSmoother::TakeOutranking(const FrameMeasurements& measurement,
                                      FrameStarts* starts) const {
  if (starts->starts.empty() || 2 * starts->starts[0].tags.size() > measurement.tags.size()) return;
  const GraphFrame& last = hypotheses_[0].input.frames.back();
  FrameStarts free = StartFrame(setup_, noise_, measurement, &last, std::nullopt);
  if (free.starts.empty()) return;
  const GraphFrame& frame = free.starts[0];
  if (!Outranks(setup_, noise_, hypotheses_[0].motion, frame)) return;
  free.starts.resize(1);
  *starts = std::move(free);
}

// Tags that agree with one another where no body could have gone meanwhile; or a turn since the
// last frame that the motion prior's local variable does not reach.
bool FixedLagSmoother::IsBreak(const FrameMeasurements& measurement,
                               const FrameStarts& starts) const {
  constexpr double kGapS = 0.2, kMostTurnRad = 2.5;
  if (hypotheses_.empty() || starts.starts.empty() || starts.starts[0].tags.empty()) return false;
  const GraphFrame& last = hypotheses_[0].input.frames.back();
  const double dt_s = ToSeconds(measurement.t_ns - last.t_ns);
  if (dt_s > kGapS && last.state.twist.omega_body.norm() * dt_s > kMostTurnRad) return true;
  const auto alone = OutOfReach(measurement, starts);
  return alone && alone->is_consensus;
}

// Tags that do not outrank the frames before, of one pose, where no body could have gone meanwhile:
// they count as little as those that a prediction excludes.
bool FixedLagSmoother::IsLeap(const FrameMeasurements& measurement,
                              const FrameStarts& starts) const {
  if (hypotheses_.size() != 1 || starts.starts.size() != 1 || starts.starts[0].tags.empty()) {
    return false;
  }
  const auto alone = OutOfReach(measurement, starts);
  return alone && !alone->is_consensus;
}

// The pose that the tags say by themselves, if no body could have gone there since the last frame.
std::optional<PoseMeasurement> FixedLagSmoother::OutOfReach(const FrameMeasurements& measurement,
                                                            const FrameStarts& starts) const {
  const GraphFrame &last = hypotheses_[0].input.frames.back(), &next = starts.starts[0];
  const double dt_s = ToSeconds(measurement.t_ns - last.t_ns);
  const Pose &from = last.state.world_from_body, &to = next.state.world_from_body;
  if (IsWithinReach(from, to, dt_s)) return std::nullopt;
  const auto alone = PoseOfTags(setup_, noise_.corner_sigma_px, next.tags, to);
  if (!alone || !IsOutOfReach(from, *alone, dt_s)) return std::nullopt;
  return alone;
}

// Which tags the solution was made with, and which of the others lie elsewhere.
void FixedLagSmoother::JudgeIds(const FrameMeasurements& measurement) {
  if (hypotheses_.size() != 1) return;
  const GraphFrame& frame = hypotheses_[0].input.frames.back();
  const size_t first = FirstSinceGap(hypotheses_[0].input.frames);
  if (first + 1 == seen_.size()) doubled_.LoseTouch();
  std::vector<int> used;
  used.reserve(frame.tags.size());
  for (const TagDetection& tag : frame.tags) {
    if (std::count(used.begin(), used.end(), tag.id) == 0) used.push_back(tag.id);
    if (alone_since_restart_ != tag.id) alone_since_restart_.reset();
  }
  std::vector<int> aside;
  for (const TagDetection& tag : measurement.tags) {
    if (std::count(used.begin(), used.end(), tag.id) == 0) aside.push_back(tag.id);
  }
  doubled_.AddSolved(used, TagsElsewhere(setup_, frame, measurement.tags), aside);
  if (!doubled_.IsAtStake()) return;
  for (size_t k = first; k < seen_.size(); ++k) seen_[k].is_doubted = true;
}

// Once an id is known to be doubled, frames that were built on one of the two are worth nothing.
void FixedLagSmoother::LeaveOutDoubled(FrameMeasurements* measurement, WindowOutput* out) {
  const bool is_news = doubled_.Add(*measurement);
  doubled_.TakeOut(&measurement->tags);
  if (is_news && !hypotheses_.empty()) LeaveAll(out);
}

// All frames leave; the next one has nothing before it.
void FixedLagSmoother::LeaveAll(WindowOutput* out) {
  for (FrameEstimate& left : EstimatesOfAll()) out->lagged.push_back(std::move(left));
  Forget(seen_.size());
  hypotheses_.clear();
  alone_since_restart_.reset();
  power_.Break();
  mirror_is_open_ = true;
  mirror_cost_of_left_ = 0;
}

// Where a frame comes too soon for the first time, those before it may have done so, too, as long
// as nobody knew what is usual.
void FixedLagSmoother::LeaveWrongStamps(WindowOutput* out) {
  constexpr size_t kUnjudged = 8;
  if (seen_.size() > kUnjudged) return;
  const size_t before = out->lagged.size();
  LeaveAll(out);
  for (size_t i = before; i < out->lagged.size(); ++i) {
    if (out->lagged[i].status != FrameStatus::kNoFix) ForgetTwist(&out->lagged[i]);
  }
}

// Whether the frame's stamp cannot be when it was taken, and there are others to go by.
bool FixedLagSmoother::ComesTooSoon(int64_t t_ns, WindowOutput* out) {
  // Cameras of their own clocks may come as soon after one another as they like.
  const bool too_soon = setup_.n_cameras() == 1 && stamps_.ComesTooSoon(t_ns);
  if (too_soon && stamps_.too_soon() == 1) LeaveWrongStamps(out);
  if (!too_soon && began_too_soon_) LeaveAll(out);  // its stamp is not of its exposure
  began_too_soon_ = too_soon && hypotheses_.empty();
  return too_soon && !hypotheses_.empty();
}

// Before it is known what stamps are usual, no body moves like that: two were stamped together.
bool FixedLagSmoother::IsSudden(const FrameEstimate& frame) const {
  return setup_.n_cameras() == 1 && !stamps_.KnowsUsual() && frame.status != FrameStatus::kNoFix &&
         MovesBeyondReach(frame.state.twist);
}

void FixedLagSmoother::LeaveForNewTimes(std::vector<FrameEstimate>* lagged) {
  if (hypotheses_.empty()) return;
  WindowOutput out;
  LeaveAll(&out);
  *lagged = std::move(out.lagged);
  const double corner_sigma_px = noise_.corner_sigma_px;
  noise_ = InitialNoise(setup_.options);
  noise_.corner_sigma_px = corner_sigma_px;
  statistics_ = NoiseStatistics();
  has_learned_ = false;
  stamps_ = StampCheck();
}

void FixedLagSmoother::StartAnew(int64_t t_ns, WindowOutput* out) {
  LeaveAll(out);
  doubled_.StartAnew();
  const bool again = restarts_ > 0 && frames_since_restart_ < kFramesToSettle;
  restarts_in_a_row_ = again ? restarts_in_a_row_ + 1 : 0;
  frames_since_restart_ = 0;
  if (restarts_++ == 0) first_restart_ns_ = t_ns;
}

// While one restart follows upon another, frames contradict one another and nobody knows which is
// right: only those whose tags agree among themselves have a state. So it is where one tag alone
// has told another place than those that agreed before: it may have a twin.
bool FixedLagSmoother::IsDoubted(const GraphFrame& frame) const {
  if (alone_since_restart_) return true;
  if (restarts_in_a_row_ == 0) return false;
  const auto alone =
      PoseOfTags(setup_, noise_.corner_sigma_px, frame.tags, frame.state.world_from_body);
  return !alone || !alone->is_consensus;
}

std::optional<std::string> FixedLagSmoother::RestartWarning() const {
  if (restarts_ == 0) return std::nullopt;
  return Format(
      "the window was started anew %zu time%s, first at %.3f s: its frames have no common "
      "solution, or tags that agree with one another contradict all that went before (a "
      "jump of the body or the clock)",
      restarts_, restarts_ == 1 ? "" : "s", ToSeconds(first_restart_ns_));
}

}  // namespace tagtwist::internal
