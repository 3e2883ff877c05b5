#include <algorithm>
#include <limits>
#include <opencv2/videoio.hpp>
#include <utility>

#include "frontend/base/files/input_file.h"
#include "frontend/base/number_text.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/io/recordings/video_frame.h"

namespace tagtwist {

using namespace internal;
namespace {

const char* const kPrefix = "camera:";

class CameraSource : public DataSource {
 public:
  CameraSource(std::string name, const cv::VideoCapture& capture, std::function<int64_t()> now_ns)
      : name_(std::move(name)), capture_(capture), now_ns_(std::move(now_ns)) {}

  Result<std::optional<Frame>> Next() override {
    if (!Grab(&capture_)) return std::optional<Frame>();
    Frame frame;
    last_ns_ = std::max(now_ns_(), last_ns_ + 1);  // stamps grow, however coarse the clock
    frame.t_ns = last_ns_;
    frame.name = name_ + ": frame " + std::to_string(n_frames_++);
    RetrieveGray(&capture_, &frame);
    return std::optional<Frame>(std::move(frame));
  }

  const std::vector<int64_t>& stamps_ns() const override { return stamps_ns_; }

 private:
  std::string name_;
  cv::VideoCapture capture_;
  std::function<int64_t()> now_ns_;
  int64_t last_ns_ = std::numeric_limits<int64_t>::min();
  size_t n_frames_ = 0;
  std::vector<int64_t> stamps_ns_;  // nobody knows them before
};

bool OpenDevice(const std::string& place, const Camera& camera, const Limits& limits,
                cv::VideoCapture* capture) {
  const auto number = ParseInteger(place);
  const bool is_device = number || place.rfind("/dev/", 0) == 0;
  const int patience_ms = static_cast<int>(std::min(1e3 * limits.first_frame_s, 1e9));
  const std::vector<int> patient = {cv::CAP_PROP_OPEN_TIMEOUT_MSEC, patience_ms,
                                    cv::CAP_PROP_READ_TIMEOUT_MSEC, patience_ms};
  const bool is_open = number      ? capture->open(static_cast<int>(*number), cv::CAP_V4L2)
                       : is_device ? capture->open(place, cv::CAP_V4L2)
                                   : capture->open(place, cv::CAP_FFMPEG, patient);
  if (is_open && !is_device) capture->set(cv::CAP_PROP_ORIENTATION_AUTO, 0);
  if (is_open && is_device) {
    capture->set(cv::CAP_PROP_FRAME_WIDTH, camera.width);
    capture->set(cv::CAP_PROP_FRAME_HEIGHT, camera.height);
    capture->set(cv::CAP_PROP_BUFFERSIZE, 1);  // an image that waits there is stamped late
  }
  return is_open;
}

}  // namespace

bool IsCamera(const std::string& dataset) { return dataset.rfind(kPrefix, 0) == 0; }

Result<std::unique_ptr<DataSource>> OpenCameraSource(const std::string& dataset,
                                                     const Camera& camera,
                                                     std::function<int64_t()> now_ns,
                                                     const Limits& limits) {
  const std::string place = dataset.substr(std::string(kPrefix).size());
  // To open a pipe without a writer never ends.
  const bool is_device = place.rfind("/dev/", 0) == 0;
  if (const Status regular = CheckRegularFile(place); !is_device && !regular) {
    return regular.error();
  }
  try {
    cv::VideoCapture capture;
    if (!place.empty() && OpenDevice(place, camera, limits, &capture)) {
      return std::unique_ptr<DataSource>(
          std::make_unique<CameraSource>(dataset, std::move(capture), std::move(now_ns)));
    }
  } catch (const cv::Exception&) {  // as if it had said no
  }
  return Error{dataset + ": no camera can be opened there"};
}

}  // namespace tagtwist
