#pragma once
#include <cstdint>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Images as they come, as one Matroska file of FFV1 frames, each of which is whole by itself, has
/// a checksum and carries its stamp in ns (frame_mark.h). Each image is on its way to the disk
/// before the next one is taken: what a run that is killed has written can be read.
class LosslessVideo {
 public:
  /// Nothing may be there yet. "x.mkv: exists already", "x.mkv: cannot write: Permission denied".
  static Result<std::unique_ptr<LosslessVideo>> Create(const std::string& path);
  ~LosslessVideo();
  LosslessVideo(const LosslessVideo&) = delete;
  LosslessVideo& operator=(const LosslessVideo&) = delete;

  /// 8-bit gray, all of one size; stamps must grow. After an error nothing more is written.
  Status Add(int64_t t_ns, const cv::Mat& gray);
  /// The file's end, with its duration and an index. Once. Without an image there is no file.
  Status Finish();

 private:
  struct Stream;  // libavformat's and libavcodec's
  LosslessVideo(std::string path, std::unique_ptr<Stream> stream);
  Status Fail(const std::string& why);
  Status FailAs(int error);
  std::string path_;
  std::unique_ptr<Stream> stream_;
  int64_t first_ns_ = 0;
  bool failed_ = false;
};

}  // namespace tagtwist::internal
