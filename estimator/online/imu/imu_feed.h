#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// Whether who asks for a recording's IMU can have it.
Status CheckImu(const std::string& dataset, const DataSource& source, const Config& config);

/// A recording's IMU as it would come with the frames.
class ImuFeed {
 public:
  /// `samples` must outlive it; `ahead_s`: how far their clock is ahead of the frames'.
  ImuFeed(const std::vector<ImuSample>& samples, double ahead_s);
  /// Those since the last call, until the first after a frame's stamp.
  std::vector<ImuSample> Until(int64_t t_ns);

 private:
  const std::vector<ImuSample>& samples_;
  int64_t ahead_ns_;
  size_t next_ = 0;
};

}  // namespace tagtwist::internal
