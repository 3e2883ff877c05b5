#pragma once
#include <memory>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>

#include "frontend/io/recordings/dataset_writer.h"

namespace tagtwist::internal {

/// The kinds behind CreateDatasetWriter; `path` is free.
Result<std::unique_ptr<DatasetWriter>> CreateFolderWriter(const std::string& path);
Result<std::unique_ptr<DatasetWriter>> CreateEurocWriter(const std::string& path);
Result<std::unique_ptr<DatasetWriter>> CreateMatWriter(const std::string& path);

/// What every writer asks of the frames: stamps that grow strictly, images 8-bit gray and of one
/// size.
class FrameRules {
 public:
  /// "path: frame 3: stamp 0.5 s repeats".
  Status Check(const FrameToWrite& frame, const std::string& path);
  size_t frames() const { return frames_; }

 private:
  size_t frames_ = 0;
  int64_t previous_ns_ = 0;
  cv::Size size_;
};

}  // namespace tagtwist::internal
