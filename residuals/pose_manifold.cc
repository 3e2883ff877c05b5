#include "residuals/pose_manifold.h"

#include <Eigen/Geometry>

#include "frontend/types/pose.h"

namespace tagtwist::internal {
namespace {
using ConstQ = Eigen::Map<const Eigen::Quaterniond>;
using Params = Eigen::Matrix<double, 7, 1>;

Pose PoseAt(const double* params) {
  Pose out;
  out.params = Eigen::Map<const Params>(params);
  return out;
}

// Columns: q * (e_i, 0), coefficient order xyzw.
Eigen::Matrix<double, 4, 3> QTimesPureQuaternion(const Eigen::Quaterniond& q) {
  Eigen::Matrix<double, 4, 3> m;
  m << q.w(), -q.z(), q.y(), q.z(), q.w(), -q.x(), -q.y(), q.x(), q.w(), -q.x(), -q.y(), -q.z();
  return m;
}
}  // namespace
bool PoseManifold::Plus(const double* x, const double* d, double* out) const {
  Eigen::Map<Params> moved(out);
  moved = Retract(PoseAt(x), Eigen::Map<const PoseStep>(d)).params;
  return true;
}
bool PoseManifold::Minus(const double* y, const double* x, double* out) const {
  Eigen::Map<PoseStep> step(out);
  step = Difference(PoseAt(y), PoseAt(x));
  return true;
}
bool PoseManifold::PlusJacobian(const double* x, double* j) const {
  Eigen::Map<Eigen::Matrix<double, 7, 6, Eigen::RowMajor>> d_plus_d_delta(j);
  d_plus_d_delta.setZero();
  d_plus_d_delta.topLeftCorner<4, 3>() = 0.5 * QTimesPureQuaternion(ConstQ(x));
  d_plus_d_delta.bottomRightCorner<3, 3>().setIdentity();
  return true;
}
bool PoseManifold::MinusJacobian(const double* x, double* j) const {
  Eigen::Map<Eigen::Matrix<double, 6, 7, Eigen::RowMajor>> d_minus_d_y(j);
  d_minus_d_y.setZero();
  d_minus_d_y.topLeftCorner<3, 4>() = 2.0 * QTimesPureQuaternion(ConstQ(x)).transpose();
  d_minus_d_y.bottomRightCorner<3, 3>().setIdentity();
  return true;
}
}  // namespace tagtwist::internal
