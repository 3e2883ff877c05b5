#include <cmath>
#include <opencv2/videoio.hpp>
#include <utility>

#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/recordings/video_frame.h"

namespace tagtwist {
namespace {

constexpr double kLeastReadable = 0.9;  // of the duration; less is a damaged file

bool OpenVideo(const std::string& path, cv::VideoCapture* capture) {
  try {
    return capture->open(path, cv::CAP_FFMPEG) &&
           (capture->set(cv::CAP_PROP_ORIENTATION_AUTO, 0), true);
  } catch (const cv::Exception&) {
    return false;
  }
}

Error NoVideo(const std::string& path) {
  return Error{path +
               ": expected a course .mat, a video or a folder, got neither, or a damaged file"};
}

class VideoSource : public DataSource {
 public:
  VideoSource(std::string path, cv::VideoCapture capture, std::vector<int64_t> stamps_ns)
      : path_(std::move(path)), capture_(std::move(capture)), stamps_ns_(std::move(stamps_ns)) {}

  Result<std::optional<Frame>> Next() override {
    if (next_ == stamps_ns_.size()) return std::optional<Frame>();
    Frame frame;
    frame.t_ns = stamps_ns_[next_];
    frame.name = path_ + ": frame " + std::to_string(next_++);
    if (Grab(&capture_)) {
      RetrieveGray(&capture_, &frame);
    } else {
      frame.image_problem = "cannot decode";
    }
    if (!frame.image.empty()) {
      if (auto fault = size_guard_.Check(frame.image, frame.name)) return *fault;
    }
    return std::optional<Frame>(std::move(frame));
  }

  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }

 private:
  std::string path_;
  cv::VideoCapture capture_;
  std::vector<int64_t> stamps_ns_;
  size_t next_ = 0;
  ImageSizeGuard size_guard_;
};

// The presentation times [ns], or, where they do not grow, the frame rate's. All of the file is
// read once: only then are the frames known.
Result<std::vector<int64_t>> ReadStamps(const std::string& path) {
  cv::VideoCapture capture;
  if (!OpenVideo(path, &capture)) return NoVideo(path);
  const double rate_hz = capture.get(cv::CAP_PROP_FPS);
  const double announced = capture.get(cv::CAP_PROP_FRAME_COUNT);
  std::vector<int64_t> stamps_ns;
  bool grows = true;
  while (capture.grab()) {
    const auto t_ns = std::llround(1e6 * capture.get(cv::CAP_PROP_POS_MSEC));
    grows = grows && (stamps_ns.empty() || t_ns > stamps_ns.back());
    stamps_ns.push_back(t_ns);
  }
  if (stamps_ns.size() < 2) return NoVideo(path);  // FFmpeg takes an image for a video of one frame
  const bool has_rate = rate_hz > 0 && std::isfinite(rate_hz);
  if (!grows) {
    if (!has_rate) return Error{path + ": a video with neither times nor a frame rate"};
    for (size_t i = 0; i < stamps_ns.size(); ++i) {
      stamps_ns[i] = std::llround(1e9 * static_cast<double>(i) / rate_hz);
    }
  }
  if (has_rate && announced > 1) {
    const double read_s = ToSeconds(stamps_ns.back() - stamps_ns.front()) + 1 / rate_hz;
    if (!(read_s >= kLeastReadable * announced / rate_hz)) {
      return Error{path + ": a damaged video: " + std::to_string(stamps_ns.size()) + " of " +
                   std::to_string(std::llround(announced)) + " frames can be read"};
    }
  }
  return stamps_ns;
}

}  // namespace

Result<std::unique_ptr<DataSource>> OpenVideoSource(const std::string& path,
                                                    const DataSourceOptions& options) {
  try {
    auto stamps_ns = ReadStamps(path);
    if (!stamps_ns) return stamps_ns.error();
    if (options.use_detections) return Error{path + ": a video has no detections to use"};
    cv::VideoCapture capture;
    if (!OpenVideo(path, &capture)) return NoVideo(path);
    return std::unique_ptr<DataSource>(
        std::make_unique<VideoSource>(path, std::move(capture), std::move(*stamps_ns)));
  } catch (const cv::Exception&) {
    return NoVideo(path);
  }
}

}  // namespace tagtwist
