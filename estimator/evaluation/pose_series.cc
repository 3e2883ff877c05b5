#include "estimator/evaluation/pose_series.h"

#include <algorithm>
#include <cmath>

#include "frontend/types/cubic.h"
#include "frontend/types/so3.h"

namespace tagtwist {
namespace {

const std::optional<Twist>& TwistOf(const ClosedForm& closed_form, ClosedFormVariant variant) {
  if (variant == ClosedFormVariant::kPlain) return closed_form.twist_plain;
  if (variant == ClosedFormVariant::kRansac) return closed_form.twist_ransac;
  return closed_form.twist_low_pass;
}

// d(error state of the marker in truth) / d(error state of the body in world), 12x12:
//   theta' = Rm' theta,  p' = A (p - R [l]x theta),  v' = A (v - R [omega x l]x theta - R [l]x w),
//   w' = Rm' w;  A = truth_from_world, R = world_from_body, Rm = body_from_marker (rotations),
//   l = origin of the marker in the body.
StateCovariance ErrorStateMap(const PoseSample& sample, const Pose& truth_from_world,
                              const Pose& body_from_marker) {
  const Eigen::Matrix3d a = truth_from_world.rotation().toRotationMatrix();
  const Eigen::Matrix3d ar = a * sample.world_from_body.rotation().toRotationMatrix();
  const Eigen::Matrix3d marker_from_body =
      body_from_marker.rotation().toRotationMatrix().transpose();
  const Eigen::Vector3d lever = body_from_marker.translation();
  const Eigen::Vector3d omega = sample.twist ? sample.twist->omega_body : Eigen::Vector3d::Zero();
  StateCovariance map = StateCovariance::Zero();
  map.block<3, 3>(0, 0) = marker_from_body;
  map.block<3, 3>(3, 0) = -ar * Hat(lever);
  map.block<3, 3>(3, 3) = a;
  map.block<3, 3>(6, 0) = -ar * Hat(omega.cross(lever));
  map.block<3, 3>(6, 6) = a;
  map.block<3, 3>(6, 9) = -ar * Hat(lever);
  map.block<3, 3>(9, 9) = marker_from_body;
  return map;
}

// Over one step the turn is small: its slope is the body rate.
Pose PoseBetween(const PoseSample& a, const PoseSample& b, double step_s, double w) {
  if (a.covariance && b.covariance && a.twist && b.twist) {
    return internal::CubicBetween({a.world_from_body, *a.twist}, {b.world_from_body, *b.twist},
                                  step_s, w)
        .world_from_body;
  }
  return Retract(a.world_from_body, w * Difference(b.world_from_body, a.world_from_body));
}

}  // namespace

PoseSeries EstimatedSeries(const std::vector<FrameEstimate>& frames) {
  PoseSeries out;
  for (const FrameEstimate& f : frames) {
    if (f.status == FrameStatus::kNoFix) continue;
    out.push_back({f.t_ns, f.state.world_from_body, f.state.twist, f.covariance});
  }
  return out;
}

PoseSeries ClosedFormSeries(const std::vector<FrameEstimate>& frames, ClosedFormVariant variant) {
  PoseSeries out;
  for (const FrameEstimate& f : frames) {
    if (!f.closed_form.world_from_body) continue;
    out.push_back(
        {f.t_ns, *f.closed_form.world_from_body, TwistOf(f.closed_form, variant), std::nullopt});
  }
  return out;
}

std::optional<PoseSample> SampleAt(const PoseSeries& series, int64_t t_ns, double max_gap_s) {
  const auto after =
      std::lower_bound(series.begin(), series.end(), t_ns,
                       [](const PoseSample& sample, int64_t t) { return sample.t_ns < t; });
  if (after == series.end()) return std::nullopt;
  if (after->t_ns == t_ns) return *after;
  if (after == series.begin()) return std::nullopt;
  const PoseSample &a = *(after - 1), &b = *after;
  const double step_s = ToSeconds(b.t_ns - a.t_ns);
  if (!(step_s <= max_gap_s)) return std::nullopt;
  const double w = ToSeconds(t_ns - a.t_ns) / step_s;
  PoseSample out;
  out.t_ns = t_ns;
  out.world_from_body = PoseBetween(a, b, step_s, w);
  if (a.twist && b.twist) {
    out.twist = Twist{(1 - w) * a.twist->v_world + w * b.twist->v_world,
                      (1 - w) * a.twist->omega_body + w * b.twist->omega_body};
  }
  if (a.covariance && b.covariance) {
    out.covariance = (1 - w) * *a.covariance + w * *b.covariance;
  }
  return out;
}

PoseSample Transform(const PoseSample& sample, const Pose& truth_from_world,
                     const Pose& body_from_marker) {
  PoseSample out = sample;
  out.world_from_body = truth_from_world * sample.world_from_body * body_from_marker;
  if (sample.twist) {
    const Eigen::Vector3d& omega = sample.twist->omega_body;
    const Eigen::Vector3d of_lever =
        sample.world_from_body.rotation() * omega.cross(body_from_marker.translation());
    out.twist->v_world = truth_from_world.rotation() * (sample.twist->v_world + of_lever);
    out.twist->omega_body = body_from_marker.rotation().conjugate() * omega;
  }
  if (sample.covariance) {
    const StateCovariance map = ErrorStateMap(sample, truth_from_world, body_from_marker);
    out.covariance = map * *sample.covariance * map.transpose();
  }
  return out;
}

std::optional<TwistRoughness> ComputeRoughness(const PoseSeries& series) {
  double velocity = 0, rate = 0;
  size_t count = 0;
  for (size_t i = 2; i < series.size(); ++i) {
    const auto &a = series[i - 2].twist, &b = series[i - 1].twist, &c = series[i].twist;
    if (!a || !b || !c) continue;
    velocity += (a->v_world - 2 * b->v_world + c->v_world).squaredNorm();
    rate += (a->omega_body - 2 * b->omega_body + c->omega_body).squaredNorm();
    ++count;
  }
  if (count == 0) return std::nullopt;
  const double scale = 6.0 * static_cast<double>(count);
  return TwistRoughness{std::sqrt(velocity / scale), std::sqrt(rate / scale)};
}

}  // namespace tagtwist
