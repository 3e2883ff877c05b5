#include "frontend/io/images/video_file.h"

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <opencv2/videoio.hpp>
#include <utility>

#include "frontend/base/atomic_file.h"

namespace tagtwist {
namespace {

std::string Ending(const std::string& path) {
  return std::filesystem::path(path).extension().string();
}

// Frames that a file says it has; 0 where it cannot be read.
size_t FramesIn(const std::string& path) {
  const cv::VideoCapture video(path, cv::CAP_FFMPEG);
  return video.isOpened() ? static_cast<size_t>(video.get(cv::CAP_PROP_FRAME_COUNT)) : 0;
}

}  // namespace

struct VideoFile::Writer {
  cv::VideoWriter video;
};

Status CheckVideoName(const std::string& path) {
  const std::string ending = Ending(path);
  if (ending != ".mp4" && ending != ".avi") {
    return Error{path + ": expected a name that ends in .mp4 or .avi"};
  }
  const auto folder = std::filesystem::path(path).parent_path();
  if (!folder.empty() && !std::filesystem::is_directory(folder)) {
    return Error{path + ": its folder is missing"};
  }
  return Ok();
}

VideoFile::VideoFile(std::string path, std::string partial, std::unique_ptr<Writer> writer)
    : path_(std::move(path)), partial_(std::move(partial)), writer_(std::move(writer)) {}

Result<std::unique_ptr<VideoFile>> VideoFile::Create(const std::string& path,
                                                     double frames_per_second,
                                                     const cv::Size& size) {
  if (const auto fine = CheckVideoName(path); !fine) return fine.error();
  const std::string partial = PartialNeighbour(path) + Ending(path);
  const int codec = Ending(path) == ".mp4" ? cv::VideoWriter::fourcc('m', 'p', '4', 'v')
                                           : cv::VideoWriter::fourcc('M', 'J', 'P', 'G');
  auto writer = std::make_unique<Writer>();
  if (!writer->video.open(partial, cv::CAP_FFMPEG, codec, frames_per_second, size)) {
    std::error_code ignored;
    std::filesystem::remove(partial, ignored);
    return Error{path + ": cannot write a video there"};
  }
  return std::unique_ptr<VideoFile>(new VideoFile(path, partial, std::move(writer)));
}

VideoFile::~VideoFile() {
  if (partial_.empty()) return;
  writer_.reset();
  std::error_code ignored;
  std::filesystem::remove(partial_, ignored);
}

void VideoFile::Add(const cv::Mat& image) {
  writer_->video.write(image);
  ++frames_;
}

// OpenCV's writer does not tell of a full disk, so the file is asked.
Status VideoFile::Finish() {
  writer_->video.release();
  const size_t written = FramesIn(partial_);
  if (written != frames_) {
    return Error{path_ + ": cannot write: " + std::to_string(written) + " of " +
                 std::to_string(frames_) + " frames arrived"};
  }
  std::error_code failure;
  std::filesystem::rename(partial_, path_, failure);
  if (failure) return Error{path_ + ": cannot write: " + failure.message()};
  partial_.clear();
  return Ok();
}

}  // namespace tagtwist
