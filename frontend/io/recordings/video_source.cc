#include <algorithm>
#include <opencv2/videoio.hpp>
#include <utility>

#include "frontend/io/images/video_times.h"
#include "frontend/io/recordings/data_source_kinds.h"
#include "frontend/io/recordings/video_frame.h"

namespace tagtwist::internal {
namespace {

constexpr double kLeastReadable = 0.9;  // of the duration; less is a damaged file

// A rotate mark is honoured, as every player does.
bool OpenVideo(const std::string& path, cv::VideoCapture* capture) {
  try {
    return capture->open(path, cv::CAP_FFMPEG) &&
           (capture->set(cv::CAP_PROP_ORIENTATION_AUTO, 1), true);
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
  VideoSource(std::string path, const cv::VideoCapture& capture, RepairedStamps stamps,
              double step_s, std::vector<std::string> notes)
      : path_(std::move(path)),
        capture_(capture),
        stamps_(std::move(stamps)),
        step_s_(step_s),
        notes_(std::move(notes)) {}

  Result<std::optional<Frame>> Next() override {
    if (next_ == stamps_.stamps_ns.size()) return std::optional<Frame>();
    while (!stamps_.kept[in_file_]) {
      Grab(&capture_);
      ++in_file_;
    }
    Frame frame;
    frame.t_ns = stamps_.stamps_ns[next_++];
    frame.name = path_ + ": frame " + std::to_string(in_file_++);
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

  Status Skip(size_t frames) override {
    const size_t last = std::min(stamps_.stamps_ns.size(), next_ + frames);
    for (; next_ < last; ++next_) {
      while (!stamps_.kept[in_file_++]) Grab(&capture_);
      Grab(&capture_);
    }
    return Ok();
  }

  const std::vector<int64_t>& stamps_ns() const override { return stamps_.stamps_ns; }
  const std::vector<std::string>& notes() const override { return notes_; }
  double stamp_step_s() const override { return step_s_; }

 private:
  std::string path_;
  cv::VideoCapture capture_;
  RepairedStamps stamps_;
  double step_s_;
  std::vector<std::string> notes_;
  size_t in_file_ = 0, next_ = 0;  // frames of the file, and of those that are kept
  ImageSizeGuard size_guard_;
};

std::vector<std::string> NotesOn(const std::string& path, const VideoTimes& times,
                                 const RepairedStamps& stamps) {
  std::vector<std::string> out;
  const std::string all = " of " + std::to_string(times.stamps_ns.size()) + " frames ";
  if (stamps.by_rate) {
    out.push_back(path + ": no frame has a time: they are put " +
                  std::to_string(times.rate_hz).substr(0, 7) + " to the second, the frame rate");
  }
  if (stamps.invented > 0) {
    out.push_back(path + ": " + std::to_string(stamps.invented) + all +
                  "have no time: each is put at the usual interval after the one before");
  }
  if (stamps.dropped > 0) {
    out.push_back(path + ": passed over " + std::to_string(stamps.dropped) + all +
                  "whose time repeats or runs backwards");
  }
  return out;
}

// Nothing where the file ends long before it says.
Status CheckWhole(const std::string& path, const VideoTimes& times, const RepairedStamps& stamps) {
  if (static_cast<double>(times.stamps_ns.size()) <
      kLeastReadable * static_cast<double>(times.announced_frames)) {
    return Error{path + ": a damaged video: " + std::to_string(times.stamps_ns.size()) + " of " +
                 std::to_string(times.announced_frames) + " frames can be read"};
  }
  if (!(times.duration_s > 0) || stamps.by_rate) return Ok();
  const auto frames = static_cast<double>(stamps.stamps_ns.size());
  const double read_s =
      ToSeconds(stamps.stamps_ns.back() - stamps.stamps_ns.front()) * frames / (frames - 1);
  if (read_s >= kLeastReadable * times.duration_s) return Ok();
  return Error{path + ": a damaged video: " + std::to_string(read_s).substr(0, 6) + " of " +
               std::to_string(times.duration_s).substr(0, 6) + " s can be read"};
}

}  // namespace

Result<std::unique_ptr<DataSource>> OpenVideoSource(const std::string& path,
                                                    const DataSourceOptions& options) {
  try {
    const auto times = ReadVideoTimes(path, options.limits);
    if (!times) return times.error();
    if (times->stamps_ns.size() < 2) return NoVideo(path);  // FFmpeg takes an image for a video
    auto stamps = RepairStamps(*times);
    if (!stamps) return Error{path + ": " + stamps.error().message};
    if (stamps->stamps_ns.size() < 2) return NoVideo(path);
    if (const Status whole = CheckWhole(path, *times, *stamps); !whole) return whole.error();
    if (options.use_detections)
      return Error{path + ": a video has no detections to use: leave out --use_detections"};
    cv::VideoCapture capture;
    if (!OpenVideo(path, &capture)) return NoVideo(path);
    std::vector<std::string> notes = NotesOn(path, *times, *stamps);
    const double step_s = stamps->by_rate ? 0 : RoundingOf(stamps->stamps_ns, times->step_s);
    return std::unique_ptr<DataSource>(std::make_unique<VideoSource>(
        path, std::move(capture), std::move(*stamps), step_s, std::move(notes)));
  } catch (const cv::Exception&) {
    return NoVideo(path);
  }
}

}  // namespace tagtwist::internal
