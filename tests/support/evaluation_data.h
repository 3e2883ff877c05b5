#pragma once
#include <cmath>
#include <random>
#include <vector>

#include "estimator/evaluation/pose_series.h"
#include "frontend/types/body_state.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {

/// A smooth flight whose pose and twist are known in closed form: roll, pitch and yaw all move, so
/// that every part of a hand-eye alignment can be told.
inline BodyState SmoothState(double t) {
  BodyState s;
  const Eigen::Vector3d p(std::sin(0.7 * t), 1.3 * std::cos(0.5 * t),
                          1.5 + 0.3 * std::sin(1.1 * t));
  const Eigen::Vector3d v(0.7 * std::cos(0.7 * t), -0.65 * std::sin(0.5 * t),
                          0.33 * std::cos(1.1 * t));
  const auto rotation = [](double at) {
    return ExpSo3(Eigen::Vector3d(0.4 * std::sin(0.9 * at), 0.3 * std::cos(0.6 * at),
                                  0.8 * std::sin(0.35 * at)));
  };
  s.world_from_body = MakePose(rotation(t), p);
  s.twist.v_world = v;
  s.twist.omega_body = LogSo3(rotation(t - 1e-5).conjugate() * rotation(t + 1e-5)) / 2e-5;
  return s;
}

inline std::vector<TruthSample> SmoothTruth(double duration_s, double rate_hz) {
  std::vector<TruthSample> out;
  for (int i = 0; i <= static_cast<int>(duration_s * rate_hz); ++i) {
    const auto t_ns = static_cast<int64_t>(std::llround(1e9 * i / rate_hz));
    const BodyState s = SmoothState(ToSeconds(t_ns));
    out.push_back({t_ns, s.world_from_body, s.twist});
  }
  return out;
}

/// Stamps from first_s on, `rate_hz` apart.
inline PoseSeries SmoothSeries(double first_s, size_t count, double rate_hz) {
  PoseSeries out;
  for (size_t i = 0; i < count; ++i) {
    const double t = first_s + static_cast<double>(i) / rate_hz;
    const BodyState s = SmoothState(t);
    out.push_back({std::llround(1e9 * t), s.world_from_body, s.twist, std::nullopt});
  }
  return out;
}

inline StateVector NormalVector(std::mt19937_64& rng) {
  std::normal_distribution<double> normal;
  StateVector v;
  for (int i = 0; i < 12; ++i) v(i) = normal(rng);
  return v;
}

/// A full covariance with the scales of a real one (mrad, mm, cm/s, 10 mrad/s) and correlations.
inline StateCovariance RealisticCovariance(std::mt19937_64& rng) {
  StateVector scale;
  scale << Eigen::Vector3d::Constant(2e-3), Eigen::Vector3d::Constant(3e-3),
      Eigen::Vector3d::Constant(2e-2), Eigen::Vector3d::Constant(5e-2);
  StateCovariance a;
  for (int i = 0; i < 12; ++i) a.col(i) = NormalVector(rng);
  const StateCovariance p = a * a.transpose() / 12 + 0.3 * StateCovariance::Identity();
  return scale.asDiagonal() * p * scale.asDiagonal();
}

}  // namespace tagtwist::internal
