#include "frontend/io/images/video_file.h"

#include <filesystem>
#include <opencv2/videoio.hpp>
#include <system_error>
#include <utility>

namespace tagtwist::internal {
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

VideoFile::VideoFile(std::string path, Partial partial, std::unique_ptr<Writer> writer)
    : path_(std::move(path)), partial_(std::move(partial)), writer_(std::move(writer)) {}

Result<std::unique_ptr<VideoFile>> VideoFile::Create(const std::string& path,
                                                     double frames_per_second,
                                                     const cv::Size& size) {
  if (const auto fine = CheckVideoName(path); !fine) return fine.error();
  auto partial = Partial::Make(path, Partial::Kind::kFile, Ending(path));
  if (!partial) return partial.error();
  const int codec = Ending(path) == ".mp4" ? cv::VideoWriter::fourcc('m', 'p', '4', 'v')
                                           : cv::VideoWriter::fourcc('M', 'J', 'P', 'G');
  auto writer = std::make_unique<Writer>();
  if (!writer->video.open(partial->path(), cv::CAP_FFMPEG, codec, frames_per_second, size)) {
    return Error{path + ": cannot write a video there"};
  }
  return std::unique_ptr<VideoFile>(new VideoFile(path, std::move(*partial), std::move(writer)));
}

VideoFile::~VideoFile() = default;

void VideoFile::Add(const cv::Mat& image) {
  writer_->video.write(image);
  ++frames_;
}

// OpenCV's writer does not tell of a full disk, so the file is asked.
Status VideoFile::Finish() {
  writer_->video.release();
  const size_t written = FramesIn(partial_.path());
  if (written != frames_) {
    return Error{path_ + ": cannot write: " + std::to_string(written) + " of " +
                 std::to_string(frames_) + " frames arrived"};
  }
  const int failure = partial_.PutAt(path_);
  if (failure == 0) return Ok();
  return Error{path_ + ": cannot write: " + std::generic_category().message(failure)};
}

}  // namespace tagtwist::internal
