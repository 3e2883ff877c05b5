#pragma once
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/tables/stamps.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// Reads IMU samples, stamps growing strictly: "t,ax,ay,az,gx,gy,gz" in seconds, m/s^2 and rad/s,
/// or EuRoC/ASL's "timestamp,w_RS_S_x,...,a_RS_S_z" in ns.
Result<std::vector<ImuSample>> ReadImuCsv(const std::string& path, TimeUnit unit,
                                          std::vector<std::string>* notes = nullptr,
                                          const Limits& limits = {});
std::string FormatImuCsv(const std::vector<ImuSample>& imu, TimeUnit unit);

}  // namespace tagtwist::internal
