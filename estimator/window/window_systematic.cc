#include "estimator/window/window_systematic.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace tagtwist::internal {
namespace {

// Those of the tags that the state was made with.
std::vector<TagDetection> UsedOf(const std::vector<TagDetection>& tags,
                                 const std::vector<int>& used) {
  std::vector<TagDetection> out;
  out.reserve(used.size());
  for (const TagDetection& tag : tags) {
    if (std::find(used.begin(), used.end(), tag.id) != used.end()) out.push_back(tag);
  }
  return out;
}

// The share of a frame's own tags in what is known of its pose: the rest comes from others.
double ShareOfOwn(const PosePush& own, const FrameEstimate& frame) {
  const PoseCovariance pose = frame.covariance.topLeftCorner<6, 6>();
  return std::clamp((own.information * pose).trace() / 6, 1e-3, 1.0);
}

// A frame's covariance over that of its own tags alone is the sum of the squared weights that its
// estimate gives to the frames, which sum up to one. Weights that fall geometrically, by f a frame,
// have (1 - f) / (1 + f) backwards, and (1 - f) (1 + f^2) / (1 + f)^3 to both sides.
double FadeOf(double share, bool to_both_sides) {
  if (!to_both_sides) return (1 - share) / (1 + share);
  double low = 0, high = 1;
  for (int k = 0; k < 20; ++k) {
    const double f = 0.5 * (low + high);
    const double squares = (1 - f) * (1 + f * f) / ((1 + f) * (1 + f) * (1 + f));
    (squares > share ? low : high) = f;
  }
  return 0.5 * (low + high);
}

}  // namespace

void SystematicShift::AddTo(const PosePush& own, const std::deque<PosePush>& later,
                            FrameEstimate* frame) {
  if (frame->status == FrameStatus::kNoFix) {
    *this = SystematicShift();
    return;
  }
  if (faded_.push.size() == 0) faded_.push = Eigen::MatrixXd::Zero(6, own.push.cols());
  const double share = ShareOfOwn(own, *frame);
  const double fade = FadeOf(share, !later.empty());
  faded_.information = fade * faded_.information + own.information;
  faded_.push = fade * faded_.push + own.push;
  PosePush all = faded_;
  double weight = 1;
  for (const PosePush& next : later) {
    weight *= fade;
    all.information += weight * next.information;
    all.push += weight * next.push;
  }
  all.information.diagonal() *= 1 + 1e-9;
  const Eigen::LDLT<PoseCovariance> ldlt(all.information);
  if (ldlt.info() != Eigen::Success || !ldlt.isPositive()) return;
  const Eigen::MatrixXd before = std::exchange(shift_, ldlt.solve(all.push));
  Eigen::MatrixXd effect = Eigen::MatrixXd::Zero(12, own.push.cols());
  effect.topRows<6>() = shift_;
  const double dt_s = ToSeconds(own.t_ns - faded_.t_ns);
  if (before.size() > 0 && dt_s > 0) {
    effect.middleRows<3>(6) = (shift_.bottomRows<3>() - before.bottomRows<3>()) / dt_s;
    effect.bottomRows<3>() = (shift_.topRows<3>() - before.topRows<3>()) / dt_s;
  }
  faded_.t_ns = own.t_ns;
  if (effect.allFinite()) frame->covariance += effect * effect.transpose();
}

void WindowSystematic::AddTo(const FrameMeasurements& measurement, const NoiseModel& noise,
                             WindowOutput* out) {
  const bool has_state = out->current.status != FrameStatus::kNoFix;
  seen_.push_back(
      {out->current.t_ns, out->current.state.world_from_body,
       has_state ? UsedOf(measurement.tags, out->used_tags) : std::vector<TagDetection>()});
  Learn(noise, out->lagged);
  if (errors_.AreAny()) {
    if (pushes_.size() + 1 == seen_.size()) pushes_.push_back(PushOf(seen_.back(), noise));
    at_arrival_.AddTo(pushes_.back(), {}, &out->current);
  }
  AddTo(&out->lagged);
}

PosePush WindowSystematic::PushOf(const Seen& seen, const NoiseModel& noise) const {
  PosePush out{seen.t_ns, PoseCovariance::Zero(), {}};
  const SystematicBasis& basis = errors_.basis();
  Eigen::MatrixXd of_parameters = Eigen::MatrixXd::Zero(6, basis.size());
  SystematicBasis::TagTerms terms;
  for (const TagDetection& tag : seen.tags) {
    if (!basis.Linearize(noise, seen.world_from_body, tag, &terms)) continue;
    out.information += terms.by_pose.transpose() * terms.by_pose;
    const Eigen::MatrixXd push = terms.by_pose.transpose() * terms.by_parameters;
    for (size_t k = 0; k < terms.columns.size(); ++k) {
      of_parameters.col(terms.columns[k]) += push.col(static_cast<Eigen::Index>(k));
    }
  }
  out.push = errors_.TimesRoot(of_parameters);
  return out;
}

void WindowSystematic::Learn(const NoiseModel& noise, const std::vector<FrameEstimate>& lagged) {
  bool changed = errors_.AreAny() && pushes_.empty();  // at the start, where any are given
  auto seen = seen_.begin();
  for (const FrameEstimate& frame : lagged) {
    while (seen != seen_.end() && seen->t_ns < frame.t_ns) ++seen;
    if (seen == seen_.end()) break;
    const bool tells = seen->t_ns == frame.t_ns && !seen->tags.empty();
    if (!tells || frame.status == FrameStatus::kNoFix) continue;
    changed = errors_.Add(noise, frame.t_ns, frame.state, seen->tags) || changed;
  }
  if (changed) PushAnew(noise);
}

// In the parameters that are known from now on.
void WindowSystematic::PushAnew(const NoiseModel& noise) {
  at_arrival_ = at_lag_ = SystematicShift();
  pushes_.clear();
  if (!errors_.AreAny()) return;
  for (const Seen& seen : seen_) pushes_.push_back(PushOf(seen, noise));
}

void WindowSystematic::AddTo(std::vector<FrameEstimate>* lagged) {
  for (FrameEstimate& frame : *lagged) {
    while (!seen_.empty() && seen_.front().t_ns < frame.t_ns) TakeOldest();
    if (seen_.empty() || seen_.front().t_ns != frame.t_ns) continue;
    if (const auto own = TakeOldest()) at_lag_.AddTo(*own, pushes_, &frame);
  }
}

std::optional<PosePush> WindowSystematic::TakeOldest() {
  seen_.pop_front();
  if (pushes_.empty()) return std::nullopt;
  PosePush out = std::move(pushes_.front());
  pushes_.pop_front();
  return out;
}

}  // namespace tagtwist::internal
