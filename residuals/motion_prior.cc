#include "residuals/motion_prior.h"

#include <cmath>

namespace tagtwist {
namespace {

// Over an interval of 1 s and for a density of 1 the covariance is U U', U upper triangular with
// the diagonal [u0 u1 1] and the rows [u0 u1/2 1/6], [u1 1/2]: u0^2 = 1/720 + x/12, u1^2 = 1/12 + x
// with x = (shake_s / dt_s)^2, which is what the shake adds.
struct Triangle {
  double u0_jerk = 1.0 / 720, u0_shake, u1_jerk = 1.0 / 12, u1_shake;  // squares
};

Triangle TriangleOf(const MotionPrior& prior, double dt_s) {
  const double ratio = prior.shake_s / dt_s;
  Triangle out;
  out.u0_shake = ratio * ratio / 12;
  out.u1_shake = ratio * ratio;
  return out;
}

}  // namespace

Eigen::Matrix3d Transition(WhiteNoiseOn on, double dt_s) {
  Eigen::Matrix3d f = Eigen::Matrix3d::Zero();
  f.row(0) << 1, dt_s, 0;
  f.row(1) << 0, 1, 0;
  if (on == WhiteNoiseOn::kJerk) {
    f.col(2) << dt_s * dt_s / 2, dt_s, 1;
  }
  return f;
}

Eigen::Matrix3d ProcessCovariance(const MotionPrior& prior, double dt_s) {
  const double t1 = prior.psd * dt_s, t2 = t1 * dt_s, t3 = t2 * dt_s, t4 = t3 * dt_s;
  Eigen::Matrix3d q;
  if (prior.on == WhiteNoiseOn::kAcceleration) {
    q << t3 / 3, t2 / 2, 0, t2 / 2, t1, 0, 0, 0, 1;
  } else {
    q << t4 * dt_s / 20, t4 / 8, t3 / 6, t4 / 8, t3 / 3, t2 / 2, t3 / 6, t2 / 2, t1;
    const double s2 = prior.shake_s * prior.shake_s;
    q.topLeftCorner<2, 2>() += s2 * (Eigen::Matrix2d() << t3 / 3, t2 / 2, t2 / 2, t1).finished();
  }
  return q;
}

Eigen::Matrix3d RootInformation(const MotionPrior& prior, double dt_s) {
  const double d0 = 1 / std::sqrt(prior.psd * dt_s), d1 = d0 / dt_s, d2 = d1 / dt_s;
  Eigen::Matrix3d w;
  if (prior.on == WhiteNoiseOn::kAcceleration) {
    w << std::sqrt(12.0) * d1, -std::sqrt(3.0) * d0, 0, 0, d0, 0, 0, 0,
        prior.leaves_third_free ? 0 : 1;
  } else {
    const Triangle u = TriangleOf(prior, dt_s);
    const double w0 = 1 / std::sqrt(u.u0_jerk + u.u0_shake),
                 w1 = 1 / std::sqrt(u.u1_jerk + u.u1_shake);
    w << w0 * d2, -w0 / 2 * d1, w0 / 12 * d0, 0, w1 * d1, -w1 / 2 * d0, 0, 0, d0;
  }
  return w;
}

Eigen::Array3d ShareOfShake(const MotionPrior& prior, double dt_s) {
  if (prior.on != WhiteNoiseOn::kJerk) return Eigen::Array3d::Zero();
  const Triangle u = TriangleOf(prior, dt_s);
  return {u.u0_shake / (u.u0_jerk + u.u0_shake), u.u1_shake / (u.u1_jerk + u.u1_shake), 0};
}

}  // namespace tagtwist
