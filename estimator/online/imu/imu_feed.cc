#include "estimator/online/imu/imu_feed.h"

#include <cmath>

namespace tagtwist::internal {

Status CheckImu(const std::string& dataset, const DataSource& source, const Config& config) {
  if (source.imu().empty()) return Error{dataset + ": has no IMU, and one is asked for"};
  if (config.set_up.rig.mounted_on != MountedOn::kBody) {
    return Error{dataset + ": its cameras stand, and --imu is of a body that carries them"};
  }
  return Ok();
}

ImuFeed::ImuFeed(const std::vector<ImuSample>& samples, double ahead_s)
    : samples_(samples), ahead_ns_(std::llround(1e9 * ahead_s)) {}

std::vector<ImuSample> ImuFeed::Until(int64_t t_ns) {
  std::vector<ImuSample> out;
  bool is_before = true;
  for (; next_ < samples_.size() && is_before; ++next_) {
    is_before = samples_[next_].t_ns - ahead_ns_ < t_ns;
    out.push_back(samples_[next_]);
  }
  return out;
}

}  // namespace tagtwist::internal
