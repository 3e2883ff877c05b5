#include "estimator/window/window_systematic.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <utility>

namespace tagtwist::internal {
namespace {

std::vector<int> IdsOf(const TagMap& map) {
  std::vector<int> out;
  for (const Tag& tag : map.tags()) out.push_back(tag.id);
  return out;
}

// The share of a frame's own tags in what is known of its pose: the rest comes from others.
double ShareOfOwn(const PosePush& own, const FrameEstimate& frame) {
  const PoseCovariance pose = frame.covariance.topLeftCorner<6, 6>();
  return std::clamp((own.information * pose).trace() / 6, 1e-3, 1.0);
}

}  // namespace

PosePush PushOfTags(const SystematicBasis& basis, const NoiseModel& noise,
                    const std::vector<TagDetection>& tags, const FrameEstimate& frame) {
  PosePush out{frame.t_ns, PoseCovariance::Zero(), Eigen::MatrixXd::Zero(6, basis.size())};
  if (frame.status == FrameStatus::kNoFix) return out;
  SystematicBasis::TagTerms terms;
  for (const TagDetection& tag : tags) {
    if (!basis.Linearize(noise, frame.state.world_from_body, tag, &terms)) continue;
    out.information += terms.by_pose.transpose() * terms.by_pose;
    const Eigen::MatrixXd push = terms.by_pose.transpose() * terms.by_parameters;
    for (size_t k = 0; k < terms.columns.size(); ++k) {
      out.push.col(terms.columns[k]) += push.col(static_cast<Eigen::Index>(k));
    }
  }
  return out;
}

// Weights fall geometrically on either side, so that they sum up to one over the share.
void SystematicShift::AddTo(const SystematicBasis& basis, const PosePush& own,
                            const std::deque<PosePush>& later, FrameEstimate* frame) {
  if (frame->status == FrameStatus::kNoFix) {
    *this = SystematicShift();
    return;
  }
  if (faded_.push.size() == 0) faded_.push = Eigen::MatrixXd::Zero(6, basis.size());
  const double share = ShareOfOwn(own, *frame);
  const double fade = later.empty() ? 1 - share : (1 - share) / (1 + share);
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
  Eigen::MatrixXd effect = Eigen::MatrixXd::Zero(12, basis.size());
  effect.topRows<6>() = shift_;
  const double dt_s = ToSeconds(own.t_ns - faded_.t_ns);
  if (before.size() > 0 && dt_s > 0) {
    effect.middleRows<3>(6) = (shift_.bottomRows<3>() - before.bottomRows<3>()) / dt_s;
    effect.bottomRows<3>() = (shift_.topRows<3>() - before.topRows<3>()) / dt_s;
  }
  faded_.t_ns = own.t_ns;
  const Eigen::MatrixXd root = basis.TimesGivenSigmas(effect);
  if (root.allFinite()) frame->covariance += root * root.transpose();
}

WindowSystematic::WindowSystematic(const EstimatorSetup& setup) : basis_(setup, IdsOf(setup.map)) {}

bool WindowSystematic::IsAsked(const EstimatorOptions& options) {
  return options.systematic_errors && (options.focal_sigma || options.lens_field_sigma_px ||
                                       options.tag_sigma_m || options.corner_bias_sigma_px);
}

void WindowSystematic::AddTo(const FrameMeasurements& measurement, const NoiseModel& noise,
                             WindowOutput* out) {
  seen_.push_back(PushOfTags(basis_, noise, measurement.tags, out->current));
  at_arrival_.AddTo(basis_, seen_.back(), {}, &out->current);
  AddTo(&out->lagged);
}

void WindowSystematic::AddTo(std::vector<FrameEstimate>* lagged) {
  for (FrameEstimate& frame : *lagged) {
    while (!seen_.empty() && seen_.front().t_ns < frame.t_ns) seen_.pop_front();
    if (seen_.empty() || seen_.front().t_ns != frame.t_ns) continue;
    const PosePush own = std::move(seen_.front());
    seen_.pop_front();
    at_lag_.AddTo(basis_, own, seen_, &frame);
  }
}

}  // namespace tagtwist::internal
