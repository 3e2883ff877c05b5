#include "estimator/imu/imu_solution.h"

#include <cmath>

#include "estimator/linear/block_banded.h"
#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

constexpr int kStateSize = BlockBandedMatrix::kSize;

}  // namespace

void Widen(double common_rotation_sigma_rad, ImuResult* found) {
  found->gravity_sigma_rad = std::hypot(found->gravity_sigma_rad, common_rotation_sigma_rad);
  for (double& sigma : found->mount_sigma_rad) {
    sigma = std::hypot(sigma, common_rotation_sigma_rad);
  }
}

NoiseModel WithImu(const NoiseModel& noise) {
  NoiseModel out = noise;
  out.linear = out.angular = {WhiteNoiseOn::kAcceleration, 1.0, /*leaves_third_free=*/true};
  return out;
}

void AddSharedErrors(const std::vector<Eigen::VectorXd>& errors, Trajectory* trajectory,
                     std::vector<StateCovariance>* covariances) {
  for (const Eigen::VectorXd& error : errors) {
    for (size_t k = 0; k < trajectory->states.size(); ++k) {
      const auto at = error.segment<kStateSize>(static_cast<Eigen::Index>(k) * kStateSize);
      trajectory->covariances[k] += at * at.transpose();
      (*covariances)[k] += at.head<12>() * at.head<12>().transpose();
      if (k == 0) continue;
      const auto before = error.segment<kStateSize>(static_cast<Eigen::Index>(k - 1) * kStateSize);
      trajectory->cross_covariances[k - 1] += at * before.transpose();
    }
  }
}

std::string TextOf(const ImuResult& found) {
  const auto& g = found.gravity_world_mps2;
  const Eigen::Vector3d place_mm = 1e3 * found.imu_in_body_m;
  constexpr double kDegPerRad = 57.29577951308232;
  return Format(
      "IMU: in the estimate over %d intervals; gravity (%.3f, %.3f, %.3f) m/s^2, its clock %+.2f "
      "+- %.2f ms, its axes %.2f +- %.2f deg from the set-up's, at (%.1f, %.1f, %.1f) +- %.1f mm "
      "in the body, noise %.2g rad/s and %.2g m/s^2 per root Hz",
      found.intervals, g.x(), g.y(), g.z(), 1e3 * found.time_offset_s,
      1e3 * found.time_offset_sigma_s, kDegPerRad * found.mount_rad.norm(),
      kDegPerRad * found.mount_sigma_rad.maxCoeff(), place_mm.x(), place_mm.y(), place_mm.z(),
      1e3 * found.imu_in_body_sigma_m.maxCoeff(), found.gyro_noise, found.accel_noise);
}

}  // namespace tagtwist::internal
