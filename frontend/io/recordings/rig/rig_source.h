#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist {

/// The recording of one camera of a rig.
struct RigRecording {
  std::string path;             // as of OpenDataSource
  std::string topic;            // of its images in a bag; empty: the only one that has any
  int64_t clock_offset_ns = 0;  // its stamps plus this are times of the body's clock
};

/// The recordings of a rig's cameras, in order, as one, merged by time: a frame has the time of the
/// body's clock and its camera's index; frames that several cameras took within 20 us of one
/// another are one (Frame::others). Ground truth and IMU, in the time of the body's clock, are
/// those of the first recording that has any. An error beside those of OpenDataSource: a recording
/// that shares no time with the first.
Result<std::unique_ptr<DataSource>> OpenRigSource(const std::vector<RigRecording>& recordings,
                                                  const DataSourceOptions& options);

}  // namespace tagtwist
