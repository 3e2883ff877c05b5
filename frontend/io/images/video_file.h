#pragma once
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "frontend/base/files/partial.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Why no video can be written under that name: it must end in .mp4 or .avi, in a folder that is
/// there.
Status CheckVideoName(const std::string& path);

/// A video being written: MPEG-4 in an .mp4, Motion JPEG in an .avi. It appears under its name when
/// it is whole, or not at all.
class VideoFile {
 public:
  /// The name must be fine.
  static Result<std::unique_ptr<VideoFile>> Create(const std::string& path,
                                                   double frames_per_second, const cv::Size& size);
  ~VideoFile();
  VideoFile(const VideoFile&) = delete;
  VideoFile& operator=(const VideoFile&) = delete;

  /// 8-bit BGR of that size.
  void Add(const cv::Mat& image);
  /// Once, after the last image.
  Status Finish();

 private:
  struct Writer;  // OpenCV's
  VideoFile(std::string path, Partial partial, std::unique_ptr<Writer> writer);

  std::string path_;
  Partial partial_;
  std::unique_ptr<Writer> writer_;  // goes first: it holds the file open
  size_t frames_ = 0;
};

}  // namespace tagtwist::internal
