#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <vector>

#include "frontend/types/pose.h"

namespace tagtwist {

/// Velocity of the body: of its origin relative to W expressed in W [m/s], and its angular rate
/// relative to W expressed in B [rad/s].
struct Twist {
  Eigen::Vector3d v_world = Eigen::Vector3d::Zero();
  Eigen::Vector3d omega_body = Eigen::Vector3d::Zero();
};

/// State of a frame. Error state, everywhere, 12 entries:
/// [theta(3) rad in B, right perturbation; p(3) m in W; v_world(3) m/s; omega_body(3) rad/s].
struct BodyState {
  Pose world_from_body;
  Twist twist;
};

using StateVector = Eigen::Matrix<double, 12, 1>;
using StateCovariance = Eigen::Matrix<double, 12, 12>;
/// Covariance of the pose alone, the first six entries of the error state.
using PoseCovariance = Eigen::Matrix<double, 6, 6>;

/// Error state of `state` as seen from `reference`: state = reference [+] difference.
StateVector Difference(const BodyState& state, const BodyState& reference);
/// state [+] step: the inverse of Difference.
BodyState Retract(const BodyState& state, const StateVector& step);

/// The mean twist of a body that goes from one pose to the other in dt_s.
Twist TwistBetween(const Pose& first, const Pose& second, double dt_s);

/// Time is integer nanoseconds inside; files hold seconds (or ns where the format says so).
struct TruthSample {
  int64_t t_ns = 0;
  Pose world_from_body;
  std::optional<Twist> twist;  // absent where the file has poses only
};

/// What the body's IMU said: specific force [m/s^2] and rate [rad/s], in its own frame.
struct ImuSample {
  int64_t t_ns = 0;
  Eigen::Vector3d accel_mps2 = Eigen::Vector3d::Zero();
  Eigen::Vector3d gyro_radps = Eigen::Vector3d::Zero();
};

inline double ToSeconds(int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns); }

}  // namespace tagtwist
