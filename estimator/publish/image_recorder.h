#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Images as they come, as a plain folder that --dataset reads: images/000000.png, ... and
/// timestamps.csv, which gets a frame's row once its image is whole. So what a run that is killed
/// has recorded can be read.
class ImageRecorder {
 public:
  /// A folder that is there must be empty. "rec: exists already and is not empty".
  static Result<std::unique_ptr<ImageRecorder>> Create(const std::string& folder);
  ~ImageRecorder();
  ImageRecorder(const ImageRecorder&) = delete;
  ImageRecorder& operator=(const ImageRecorder&) = delete;

  /// Stamps must grow. An empty image is a frame without one. After an error nothing more is
  /// written.
  Status Add(int64_t t_ns, const cv::Mat& gray);

 private:
  ImageRecorder(std::string folder, int table) : folder_(std::move(folder)), table_(table) {}
  Status Fail(const std::string& file, int failure);
  std::string folder_;
  int table_;  // descriptor of timestamps.csv
  size_t frames_ = 0;
  bool failed_ = false;
};

}  // namespace tagtwist::internal
