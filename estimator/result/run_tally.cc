#include "estimator/result/run_tally.h"

#include <algorithm>
#include <cmath>

#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kStretchesTold = 3;
constexpr size_t kStepsForUsual = 8192;

bool HasAState(const FrameEstimate& frame) { return frame.status != FrameStatus::kNoFix; }

// By more than a lone small tag's pose may be off, and five of the state's own sigmas.
bool LiesElsewhere(const FrameEstimate& frame, const Pose& pose) {
  constexpr double kTagRad = 0.35, kTagM = 0.3, kSigmas = 5;
  const PoseStep d = Difference(pose, frame.state.world_from_body);
  return d.head<3>().norm() > kTagRad + kSigmas * Sigma3(frame.covariance, 0) ||
         d.tail<3>().norm() > kTagM + kSigmas * Sigma3(frame.covariance, 3);
}

bool IsAWay(const Pose& from, const Pose& to, double dt_s) {
  constexpr double kMostMps = 10, kMostRadps = 20;
  const PoseStep d = Difference(to, from);
  return d.head<3>().norm() < kMostRadps * dt_s && d.tail<3>().norm() < kMostMps * dt_s;
}

}  // namespace

double Sigma3(const StateCovariance& covariance, int first) {
  return std::sqrt(covariance.diagonal().segment<3>(first).sum());
}

void StretchTally::Add(double t_s, bool holds) {
  if (!holds) {
    Close();
    return;
  }
  ++count_;
  if (open_.frames == 0) {
    open_.from_s = t_s;
    ++stretches_;
  }
  open_.to_s = t_s;
  ++open_.frames;
}

void StretchTally::Close() {
  if (open_.frames == 0) return;
  const auto shorter = std::find_if(longest_.begin(), longest_.end(), [&](const Stretch& other) {
    return other.frames < open_.frames;
  });
  longest_.insert(shorter, open_);
  if (longest_.size() > kStretchesTold) longest_.pop_back();
  open_ = Stretch();
}

std::string StretchTally::Text() const {
  StretchTally closed = *this;
  closed.Close();
  std::vector<Stretch>& told = closed.longest_;
  std::sort(told.begin(), told.end(),
            [](const Stretch& a, const Stretch& b) { return a.from_s < b.from_s; });
  std::string out;
  for (const Stretch& s : told) {
    if (!out.empty()) out += ", ";
    out += s.frames == 1 ? Format("%.2f s", s.from_s) : Format("%.2f to %.2f s", s.from_s, s.to_s);
  }
  const size_t more = stretches_ - told.size();
  if (more > 0) out += Format(" and %zu other time%s", more, more == 1 ? "" : "s");
  return out;
}

void StepTally::Add(double from_s, double step_s) {
  if (step_s > figures_.longest_s) {
    figures_.longest_s = step_s;
    figures_.longest_from_s = from_s;
  }
  if (figures_.usual_s > 0) {
    Count(step_s);
    return;
  }
  first_.push_back(step_s);
  if (first_.size() == kStepsForUsual) TakeUsual();
}

void StepTally::TakeUsual() {
  figures_.usual_s = Quantile(first_, 0.5);
  for (const double step_s : first_) Count(step_s);
  first_ = std::vector<double>();
}

void StepTally::Count(double step_s) {
  if (step_s > kGap * figures_.usual_s) {
    ++figures_.gaps;
    figures_.missing += std::round(step_s / figures_.usual_s) - 1;
    return;
  }
  const double off = step_s - figures_.usual_s;
  ++ordinary_;
  off_ += off;
  off_squares_ += off * off;
}

std::optional<StepTally::Figures> StepTally::Get() const {
  StepTally all = *this;
  if (!all.first_.empty()) all.TakeUsual();
  if (all.ordinary_ == 0) return std::nullopt;
  const auto n = static_cast<double>(all.ordinary_);
  const double off = all.off_ / n;
  all.figures_.mean_s = all.figures_.usual_s + off;
  all.figures_.mean_square_s2 = std::max(0.0, all.off_squares_ / n - off * off);
  return all.figures_;
}

void TwistChanges::Add(const std::optional<Twist>& twist) {
  if (before_last && last && twist) {
    velocity += (before_last->v_world - 2 * last->v_world + twist->v_world).squaredNorm();
    rate += (before_last->omega_body - 2 * last->omega_body + twist->omega_body).squaredNorm();
    ++count;
  }
  before_last = last;
  last = twist;
}

void FewTagsTally::Add(double t_s, const FrameEstimate& frame) {
  const bool few = frame.n_tags < fewer_than;
  where.Add(t_s, few);
  if (few && HasAState(frame)) worst_m = std::max(worst_m.value_or(0), Sigma3(frame.covariance, 3));
}

void UnheardTags::Add(double t_s, const FrameEstimate& frame) {
  constexpr size_t kEnough = 5;
  const std::optional<Pose>& pose = frame.closed_form.world_from_body;
  const bool sees = pose && HasAState(frame);
  const bool is_one = sees && frame.n_tags == 0 && LiesElsewhere(frame, *pose);
  if (is_one) {
    const bool goes_on = last_ && IsAWay(*last_, *pose, t_s - last_s_);
    in_a_row_ = goes_on || !last_ ? in_a_row_ + 1 : 1;
  } else if (sees) {
    in_a_row_ = 0;
  }
  where.Add(t_s, is_one && in_a_row_ >= kEnough);
  last_ = is_one ? pose : std::nullopt;
  last_s_ = t_s;
}

void FrameTally::Add(const FrameEstimate& frame) {
  if (frames == 0) first_ns = frame.t_ns;
  const double t_s = ToSeconds(frame.t_ns - first_ns);
  AddNeighbours(frame, t_s);
  last_ns = frame.t_ns;
  ++frames;
  ++by_status[static_cast<size_t>(frame.status)];
  const bool is_ambiguous = frame.status == FrameStatus::kAmbiguous, sees = frame.n_tags > 0;
  with_state += HasAState(frame) ? 1 : 0;
  with_tags += sees ? 1 : 0;
  if (with_state == 0 && with_tags == 0) ++before_first_tag;
  without_state.Add(t_s, !HasAState(frame));
  ambiguous.Add(t_s, is_ambiguous && sees);
  if (is_ambiguous && sees)
    worst_ambiguous_m = std::max(worst_ambiguous_m, Sigma3(frame.covariance, 3));
  open_turns.Add(t_s, is_ambiguous && !sees);
  unheard.Add(t_s, frame);
  hurried.Add(t_s, frame.status == FrameStatus::kHurried);
  for (FewTagsTally& few : few_tags) few.Add(t_s, frame);
  const ClosedForm& c = frame.closed_form;
  const std::array<const std::optional<Twist>*, 3> twists = {&c.twist_plain, &c.twist_ransac,
                                                             &c.twist_low_pass};
  for (size_t i = 0; i < twists.size() && c.world_from_body; ++i) {
    ++closed_form[i].frames;
    closed_form[i].changes.Add(*twists[i]);
  }
  if (!HasAState(frame)) return;
  ++estimated.frames;
  estimated.changes.Add(frame.state.twist);
}

void FrameTally::AddNeighbours(const FrameEstimate& frame, double t_s) {
  const double last_s = ToSeconds(last_ns - first_ns);
  if (frames > 0) steps.Add(last_s, t_s - last_s);
  if (last_state_ && HasAState(frame)) {
    const Twist &a = last_state_->twist, &b = frame.state.twist;
    velocity_changes += (b.v_world - a.v_world).squaredNorm();
    rate_changes += (b.omega_body - a.omega_body).squaredNorm();
    changes_s += ToSeconds(frame.t_ns - last_ns);
  }
  last_state_.reset();
  if (HasAState(frame)) last_state_ = frame.state;
}

RunTally TallyOf(const Estimate& estimate, const RunTally* all) {
  if (all != nullptr) return *all;
  RunTally out;
  for (const FrameEstimate& frame : estimate.frames) out.frames.Add(frame);
  for (const FrameEstimate& frame : estimate.lagged) out.lagged.Add(frame);
  return out;
}

}  // namespace tagtwist::internal
