#pragma once
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

enum class DatasetFormat { kFolder, kEuroc, kMat };

/// One frame to write; the image may be empty (a data set of detections only).
struct FrameToWrite {
  int64_t t_ns = 0;
  cv::Mat image;  // 8-bit gray, or empty
  std::vector<TagDetection> detections;
};

/// Writes a data set frame by frame. It appears under its name whole, at Finish(), or not at all:
/// until then it lives in a temporary neighbour that the destructor removes.
class DatasetWriter {
 public:
  virtual ~DatasetWriter() = default;
  virtual Status Add(const FrameToWrite& frame) = 0;
  /// Ground truth and IMU may be empty; then their files are not written.
  virtual Status Finish(const std::vector<TruthSample>& ground_truth,
                        const std::vector<ImuSample>& imu) = 0;
};

/// An existing file or a non-empty folder at `path` is refused.
Result<std::unique_ptr<DatasetWriter>> CreateDatasetWriter(const std::string& path,
                                                           DatasetFormat format);

}  // namespace tagtwist::internal
