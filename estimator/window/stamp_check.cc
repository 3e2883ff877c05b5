#include "estimator/window/stamp_check.h"

#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

namespace {

constexpr size_t kEnough = 3;  // intervals
constexpr double kMostMps = 10, kMostRadps = 20;

}  // namespace

bool StampCheck::KnowsUsual() const { return intervals_s_.size() >= kEnough; }

bool StampCheck::ComesTooSoon(int64_t t_ns) {
  constexpr size_t kLatest = 32;
  constexpr double kShare = 1.0 / 8;
  bool out = false;
  if (last_ns_) {
    const double interval_s = ToSeconds(t_ns - *last_ns_);
    out = KnowsUsual() && interval_s < kShare * UsualS();
    if (intervals_s_.size() < kLatest) intervals_s_.emplace_back();
    intervals_s_[next_ % intervals_s_.size()] = interval_s;
    next_ = (next_ + 1) % kLatest;
  }
  last_ns_ = t_ns;
  if (out && too_soon_++ == 0) first_ns_ = t_ns;
  return out;
}

double StampCheck::UsualS() const {
  return intervals_s_.empty() ? 0 : Quantile(intervals_s_, 0.75);
}

std::optional<std::string> StampCheck::Warning() const {
  if (too_soon_ == 0) return std::nullopt;
  return Format(
      "%zu frame%s, first at %.3f s, came in less than an eighth of the usual interval: stamps "
      "are of arrival, not of exposure; these frames' tags give a pose each, but no motion",
      too_soon_, too_soon_ == 1 ? "" : "s", ToSeconds(first_ns_));
}

bool MovesBeyondReach(const Twist& twist) {
  return twist.v_world.norm() > kMostMps || twist.omega_body.norm() > kMostRadps;
}

void ForgetTwist(FrameEstimate* frame) {
  frame->state.twist = Twist();
  StateCovariance& p = frame->covariance;
  p.bottomRows<6>().setZero();
  p.rightCols<6>().setZero();
  p.diagonal().segment<3>(6).setConstant(kMostMps * kMostMps);
  p.diagonal().segment<3>(9).setConstant(kMostRadps * kMostRadps);
}

}  // namespace tagtwist::internal
