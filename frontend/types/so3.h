#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>

namespace tagtwist {

/// Skew-symmetric matrix: Hat(a) * b = a x b.
Eigen::Matrix3d Hat(const Eigen::Vector3d& v);

/// Unit quaternion of the rotation vector theta [rad].
Eigen::Quaterniond ExpSo3(const Eigen::Vector3d& theta);

/// Rotation vector [rad] of a unit quaternion, norm in [0, pi]; q and -q give the same vector.
Eigen::Vector3d LogSo3(const Eigen::Quaterniond& q);

/// Right Jacobian: Exp(theta + d) ~ Exp(theta) Exp(RightJacobian(theta) d).
/// Barfoot, State Estimation for Robotics (2017), Eq. 7.77 with the sign of theta reversed.
Eigen::Matrix3d RightJacobianSo3(const Eigen::Vector3d& theta);

/// Inverse of RightJacobianSo3; valid for |theta| < 2 pi.
Eigen::Matrix3d RightJacobianInverseSo3(const Eigen::Vector3d& theta);

/// Derivative of RightJacobianInverseSo3(theta) * v with respect to theta, v constant; 3x3.
Eigen::Matrix3d DRightJacobianInverseTimesVector(const Eigen::Vector3d& theta,
                                                 const Eigen::Vector3d& v);

}  // namespace tagtwist
