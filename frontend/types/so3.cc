#include "frontend/types/so3.h"

#include <cmath>

namespace tagtwist {
namespace {

// Below this angle the closed forms lose digits to cancellation and their series is exact to 1e-15.
constexpr double kSeriesAngle = 1e-2;

// Jr^-1(theta) = I + Hat/2 + c(|theta|) Hat^2; c and (dc/dangle) / angle.
struct InverseCoefficient {
  double c = 0, dc_over_angle = 0;
};

InverseCoefficient ComputeInverseCoefficient(double angle) {
  const double a2 = angle * angle;
  if (angle < kSeriesAngle) {  // c = 1/12 + a^2/720 + a^4/30240 + a^6/1209600 + ...
    return {1.0 / 12 + a2 * (1.0 / 720 + a2 * (1.0 / 30240 + a2 / 1209600)),
            1.0 / 360 + a2 * (1.0 / 7560 + a2 / 201600)};
  }
  // c = 1/a^2 - cot(a/2) / (2a); written with half angles it also holds at pi.
  const double s = std::sin(angle), one_minus_cos = 1.0 - std::cos(angle);
  const double value = 1.0 / a2 - 1.0 / (2.0 * angle * std::tan(0.5 * angle));
  const double derivative = -2.0 / (a2 * angle) + (s + angle) / (2.0 * a2 * one_minus_cos);
  return {value, derivative / angle};
}

}  // namespace

Eigen::Matrix3d Hat(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& theta) {
  const double n = theta.norm();
  const double k = n < 1e-4 ? 0.5 - n * n / 48.0 : std::sin(0.5 * n) / n;
  Eigen::Quaterniond q;
  q.vec() = k * theta;
  q.w() = std::cos(0.5 * n);
  return q.normalized();
}

Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q) {
  const double sign = q.w() < 0 ? -1.0 : 1.0;
  const Eigen::Vector3d v = sign * q.vec();
  const double n = v.norm();
  if (n < 1e-12) return 2.0 * v;
  return 2.0 * std::atan2(n, sign * q.w()) / n * v;
}

Eigen::Matrix3d RightJacobianSo3(const Eigen::Vector3d& theta) {
  const double n = theta.norm(), n2 = n * n;
  double a = 0.5 - n2 / 24 + n2 * n2 / 720;        // (1 - cos n) / n^2
  double b = 1.0 / 6 - n2 / 120 + n2 * n2 / 5040;  // (n - sin n) / n^3
  if (n >= kSeriesAngle) {
    a = (1 - std::cos(n)) / n2;
    b = (n - std::sin(n)) / (n2 * n);
  }
  const Eigen::Matrix3d hat = Hat(theta);
  return Eigen::Matrix3d::Identity() - a * hat + b * hat * hat;
}

Eigen::Matrix3d RightJacobianInverseSo3(const Eigen::Vector3d& theta) {
  const Eigen::Matrix3d hat = Hat(theta);
  const double c = ComputeInverseCoefficient(theta.norm()).c;
  return Eigen::Matrix3d::Identity() + 0.5 * hat + c * hat * hat;
}

Eigen::Matrix3d DRightJacobianInverseTimesVector(const Eigen::Vector3d& theta,
                                                 const Eigen::Vector3d& v) {
  // Jr^-1 v = v + theta x v / 2 + c theta x (theta x v); theta x (theta x v) =
  // theta (theta.v) - v (theta.theta).
  const InverseCoefficient k = ComputeInverseCoefficient(theta.norm());
  const Eigen::Vector3d double_cross = theta.cross(theta.cross(v));
  return -0.5 * Hat(v) + k.dc_over_angle * double_cross * theta.transpose() +
         k.c * (theta.dot(v) * Eigen::Matrix3d::Identity() + theta * v.transpose() -
                2.0 * v * theta.transpose());
}

}  // namespace tagtwist
