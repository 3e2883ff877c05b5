#include "estimator/window/online_clock.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/motion/bank/tags_alone.h"
#include "estimator/start/steady_clock.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {

OnlineClock::OnlineClock(const EstimatorSetup& setup)
    : setup_(setup), is_steady_(setup.options.clock == ClockChoice::kSteady) {}

// The latest stamps are enough: a clock drifts. A line's end moves with every stamp that comes and
// that goes, by two hundredths of what it scatters by, to and fro where stamps come in pairs: the
// ticks go on by the period and are drawn to that end.
void OnlineClock::Fit() {
  constexpr size_t kLatest = 100;
  constexpr double kLeastJitterS = 2e-4;  // less moves nothing
  constexpr double kDraw = 0.05;
  while (stamps_ns_.size() > kLatest) stamps_ns_.pop_front();
  const auto clock = FitSteadyClock({stamps_ns_.begin(), stamps_ns_.end()});
  const std::optional<int64_t> before = std::exchange(tick_ns_, std::nullopt);
  if (!clock || clock->rms_s < kLeastJitterS) return;
  const int64_t end = clock->t_ns.back();
  tick_ns_ = end;
  if (before && is_followed_) {
    const int64_t next = *before + end - clock->t_ns[clock->t_ns.size() - 2];
    const double off = static_cast<double>(end - next);
    const bool is_near = std::abs(off) < 1e9 * clock->rms_s;
    if (is_near) tick_ns_ = next + static_cast<int64_t>(std::llround(kDraw * off));
  }
  is_followed_ = true;
  is_evident_ = clock->is_evident;
  period_s_ = clock->period_s;
  rms_s_ = clock->rms_s;
}

void OnlineClock::Forget() {
  at_stamps_ = at_ticks_ = MotionBanks();
  is_followed_ = false;
  last_tick_ns_ = 0;
  advantage_ = 0;
}

int64_t OnlineClock::TimeOf(int64_t stamp_ns) {
  constexpr size_t kLeast = 20;
  constexpr int kFramesBetween = 8;  // looks at a clock that needs none
  if (setup_.options.clock == ClockChoice::kStamps) return stamp_ns;
  stamps_ns_.push_back(stamp_ns);
  if (rests_ > 0) --rests_;
  const bool looks = rests_ == 0 && (tick_ns_ || is_steady_ || ++since_fit_ >= kFramesBetween);
  if (stamps_ns_.size() >= kLeast && looks) {
    since_fit_ = 0;
    Fit();
    if (!tick_ns_) Forget();
  }
  int64_t time_ns = stamp_ns;
  if (is_steady_ && tick_ns_) {
    time_ns = *tick_ns_;
    ++n_steady_;
  }
  if (last_time_ns_ > 0) time_ns = std::max(time_ns, last_time_ns_ + 1);
  last_time_ns_ = time_ns;
  time_and_name_.emplace_back(time_ns, stamp_ns);
  return time_ns;
}

bool OnlineClock::Judge(double corner_sigma_px, const std::vector<TagDetection>& tags,
                        const Pose& near) {
  constexpr double kFade = 1 - 1.0 / 300, kClearly = 10, kRather = 1, kMost = 40;
  if (setup_.options.clock != ClockChoice::kAuto || !tick_ns_ || tags.empty()) return false;
  const auto pose = PoseOfTags(setup_, corner_sigma_px, tags, near);
  if (!pose || !pose->is_consensus || *tick_ns_ <= last_tick_ns_) return false;
  last_tick_ns_ = *tick_ns_;
  at_ticks_.Predict(*tick_ns_);
  at_ticks_.Measure(*pose);
  at_stamps_.Predict(stamps_ns_.back());
  at_stamps_.Measure(*pose);
  const PartLikelihoods ticks = at_ticks_.log_likelihoods(), stamps = at_stamps_.log_likelihoods();
  advantage_ =
      std::clamp(kFade * advantage_ + ticks.linear + ticks.angular - stamps.linear - stamps.angular,
                 -kMost, kMost);
  constexpr int kRest = 500;
  if (advantage_ == -kMost && !is_steady_ && !is_evident_) {
    rests_ = kRest;
    tick_ns_.reset();
    Forget();
  }
  const double enough = is_evident_ ? kRather : kClearly;
  const bool is_steady = is_steady_ ? advantage_ > -kClearly : advantage_ > enough;
  return std::exchange(is_steady_, is_steady) != is_steady;
}

void OnlineClock::NameOne(int64_t name_ns, FrameEstimate* frame) const {
  const auto& sigma_s = setup_.options.stamp_sigma_s;
  if (sigma_s && frame->t_ns == name_ns && frame->status != FrameStatus::kNoFix) {
    frame->covariance += OfClock(frame->state, *sigma_s);
  }
  frame->t_ns = name_ns;
}

void OnlineClock::NameByStamp(FrameEstimate* current, std::vector<FrameEstimate>* lagged) {
  if (current != nullptr) {
    NameOne(time_and_name_.empty() ? current->t_ns : time_and_name_.back().second, current);
  }
  for (FrameEstimate& frame : *lagged) {
    while (!time_and_name_.empty() && time_and_name_.front().first < frame.t_ns) {
      time_and_name_.pop_front();
    }
    const bool is_given = !time_and_name_.empty() && time_and_name_.front().first == frame.t_ns;
    NameOne(is_given ? time_and_name_.front().second : frame.t_ns, &frame);
    if (is_given) time_and_name_.pop_front();
  }
}

std::optional<std::string> OnlineClock::Warning() const {
  if (n_steady_ == 0) return std::nullopt;
  return Format(
      "the camera's clock is steady at %.3f ms, the latest stamps scatter by %.2f ms RMS around "
      "it: %zu frames were taken at its ticks; stamps name the frames",
      1e3 * period_s_, 1e3 * rms_s_, n_steady_);
}

}  // namespace tagtwist::internal
