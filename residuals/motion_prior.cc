#include "residuals/motion_prior.h"

#include <cmath>

namespace tagtwist {

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
    const double root5 = std::sqrt(5.0), root3 = std::sqrt(3.0);
    w << 12 * root5 * d2, -6 * root5 * d1, root5 * d0, 0, 2 * root3 * d1, -root3 * d0, 0, 0, d0;
  }
  return w;
}

}  // namespace tagtwist
