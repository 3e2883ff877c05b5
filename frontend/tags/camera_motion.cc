#include "frontend/tags/camera_motion.h"

#include <algorithm>

namespace tagtwist::internal {
namespace {

constexpr double kKept = 0.9;  // of the size of what was seen, from image to image
constexpr double kLeastAccel = 0.1, kLeastAngularAccel = 0.5;

}  // namespace

// How far a unit of acceleration leads from where the twist of the interval before leads to.
double CameraMotion::PerAccel(int64_t t_ns) const {
  const double ahead_s = ToSeconds(t_ns - last_->t_ns);
  return 0.5 * ahead_s * ToSeconds(t_ns - before_->t_ns);
}

PosePrediction CameraMotion::Predict(int64_t t_ns) const {
  const double ratio = ToSeconds(t_ns - last_->t_ns) / ToSeconds(last_->t_ns - before_->t_ns);
  const PoseStep step =
      ratio * Difference(last_->pose.world_from_body, before_->pose.world_from_body);
  PosePrediction out = last_->pose;
  out.world_from_body = Retract(last_->pose.world_from_body, step);
  out.covariance =
      (1 + ratio) * (1 + ratio) * last_->pose.covariance + ratio * ratio * before_->pose.covariance;
  return out;
}

std::optional<PosePrediction> CameraMotion::At(int64_t t_ns) const {
  if (!has_accel_) return std::nullopt;
  PosePrediction out = Predict(t_ns);
  const double turn = angular_accel_ * PerAccel(t_ns), shift = accel_ * PerAccel(t_ns);
  out.covariance.diagonal().head<3>().array() += turn * turn;
  out.covariance.diagonal().tail<3>().array() += shift * shift;
  return out;
}

void CameraMotion::Clear() {
  before_.reset();
  last_.reset();
  has_accel_ = false;
  accel_ = angular_accel_ = 0;
}

void CameraMotion::Add(int64_t t_ns, const PosePrediction& pose) {
  if (before_) {
    const PoseStep off = Difference(pose.world_from_body, Predict(t_ns).world_from_body);
    const double per_accel = PerAccel(t_ns);
    angular_accel_ =
        std::max({kLeastAngularAccel, kKept * angular_accel_, off.head<3>().norm() / per_accel});
    accel_ = std::max({kLeastAccel, kKept * accel_, off.tail<3>().norm() / per_accel});
    has_accel_ = true;
  }
  before_ = last_;
  last_ = Known{t_ns, pose};
}

}  // namespace tagtwist::internal
