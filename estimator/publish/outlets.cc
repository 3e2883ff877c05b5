#include "estimator/publish/outlets.h"

#include <cmath>
#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "estimator/publish/foxglove_messages.h"
#include "estimator/publish/json_text.h"
#include "estimator/publish/state_json.h"
#include "frontend/base/files/plain_name.h"
#include "frontend/io/images/lossless_video.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMostUnwritten = 64;  // that wait for a file
constexpr int kNiceness = 5;           // of those who write them

// What went wrong first, told by one thread and asked for by others.
class Problem {
 public:
  void Take(const Status& status) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!status && text_.empty()) text_ = status.error().message;
  }
  std::string text() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return text_;
  }

 private:
  mutable std::mutex mutex_;
  std::string text_;
};

class McapOutlet : public Outlet {
 public:
  McapOutlet(std::unique_ptr<McapWriter> writer, const PublishedRun& run, bool waits)
      : run_(run),
        writer_(std::move(writer)),
        worker_(
            kMostUnwritten, waits, [this](const FramePtr& frame) { Write(*frame); }, kNiceness) {}

  void Push(const FramePtr& frame) override { worker_.Push(frame); }
  std::string Finish() override {
    worker_.Finish();
    problem_.Take(writer_->Finish());
    return problem_.text();
  }
  size_t dropped() const override { return worker_.dropped(); }

 private:
  void Write(const PublishedFrame& frame) {
    if (!std::exchange(has_map_, true)) {
      problem_.Take(writer_->Write(MapMessage(run_, frame.t_ns())));
    }
    for (const FoxgloveMessage& message : NumberMessages(run_, frame, StateJsons(run_, frame))) {
      problem_.Take(writer_->Write(message));
    }
    for (const CameraImage& image : frame.images) {
      const std::string jpeg = EncodeJpeg(image.image);
      if (jpeg.empty()) continue;
      const auto camera = static_cast<size_t>(image.camera);
      problem_.Take(writer_->Write(ImageMessage(run_, camera, frame.t_ns(), jpeg)));
    }
  }

  PublishedRun run_;
  std::unique_ptr<McapWriter> writer_;
  bool has_map_ = false;
  Problem problem_;
  Worker<FramePtr> worker_;  // last member: it uses the others
};

// What a recording goes to.
struct Recorder {
  std::function<Status(const PublishedFrame& frame)> add;
  std::function<Status()> finish;
};

class RecorderOutlet : public RecordingOutlet {
 public:
  RecorderOutlet(std::string place, Recorder recorder, bool waits)
      : place_(std::move(place)),
        recorder_(std::move(recorder)),
        worker_(
            kMostUnwritten, waits,
            [this](const FramePtr& frame) {
              const Status added = recorder_.add(*frame);
              problem_.Take(added);
              if (added) ++frames_;
            },
            kNiceness) {}

  void Push(const FramePtr& frame) override {
    if (is_on_) worker_.Push(frame);
  }
  void Switch(bool on) override { is_on_ = on; }
  std::string Finish() override {
    worker_.Finish();
    problem_.Take(recorder_.finish());
    return problem_.text();
  }
  size_t dropped() const override { return worker_.dropped(); }
  std::string Json() const override {
    JsonText json;
    json.Open('{').Key("on").Truth(is_on_).Key("folder").String(place_);
    json.Key("frames").Integer(static_cast<int64_t>(frames_.load()));
    json.Key("dropped").Integer(static_cast<int64_t>(dropped()));
    return json.Key("problem").String(problem_.text()).Close('}').text();
  }

 private:
  std::string place_;
  Recorder recorder_;
  std::atomic<bool> is_on_{true};
  std::atomic<size_t> frames_{0};
  Problem problem_;
  Worker<FramePtr> worker_;  // last member: it uses the others
};

cv::Mat OnlyImage(const PublishedFrame& frame) {
  return frame.images.empty() ? cv::Mat() : frame.images.front().image;
}

// A folder in it for each camera, called after it, with the stamps of the camera's own clock: what
// `cameras` of the configuration reads by default.
Result<Recorder> OpenRigRecorder(const std::string& place, const Rig& rig) {
  std::vector<std::shared_ptr<ImageRecorder>> folders;
  std::vector<int64_t> offsets_ns;
  for (const RigCamera& camera : rig.cameras) {
    if (!IsPlainName(camera.name)) {
      return Error{"--record: a folder cannot be called after the camera '" + camera.name +
                   "': expected letters, digits, - and _"};
    }
    auto opened = ImageRecorder::Create(place + "/" + camera.name);
    if (!opened) return opened.error();
    folders.push_back(std::move(*opened));
    offsets_ns.push_back(static_cast<int64_t>(std::llround(1e9 * camera.clock_offset_s)));
  }
  return Recorder{[folders, offsets_ns](const PublishedFrame& frame) {
                    for (const CameraImage& image : frame.images) {
                      const auto i = static_cast<size_t>(image.camera);
                      const Status added =
                          folders.at(i)->Add(frame.t_ns() - offsets_ns[i], image.image);
                      if (!added) return added;
                    }
                    return Ok();
                  },
                  [] { return Ok(); }};
}

// A frame without an image is a row of the folder's table, and nothing in a video.
Result<Recorder> OpenRecorder(const std::string& place, const Rig& rig) {
  const bool is_video = std::filesystem::path(place).extension() == ".mkv";
  if (rig.IsOfSeveral() && is_video) {
    return Error{place + ": a video is of one camera, and here are several: --record FOLDER"};
  }
  if (rig.IsOfSeveral()) return OpenRigRecorder(place, rig);
  if (is_video) {
    auto opened = LosslessVideo::Create(place);
    if (!opened) return opened.error();
    const std::shared_ptr<LosslessVideo> video = std::move(*opened);
    return Recorder{[video](const PublishedFrame& frame) {
                      const cv::Mat gray = OnlyImage(frame);
                      return gray.empty() ? Ok() : video->Add(frame.t_ns(), gray);
                    },
                    [video] { return video->Finish(); }};
  }
  auto opened = ImageRecorder::Create(place);
  if (!opened) return opened.error();
  const std::shared_ptr<ImageRecorder> folder = std::move(*opened);
  return Recorder{
      [folder](const PublishedFrame& frame) { return folder->Add(frame.t_ns(), OnlyImage(frame)); },
      [] { return Ok(); }};
}

}  // namespace

Result<std::unique_ptr<Outlet>> OpenMcapOutlet(const std::string& path, const PublishedRun& run,
                                               bool waits) {
  auto writer = McapWriter::Create(path, FoxgloveChannels(run));
  if (!writer) return writer.error();
  return std::unique_ptr<Outlet>(std::make_unique<McapOutlet>(std::move(*writer), run, waits));
}

Result<std::unique_ptr<RecordingOutlet>> OpenRecording(const std::string& place, const Rig& rig,
                                                       bool waits) {
  auto recorder = OpenRecorder(place, rig);
  if (!recorder) return recorder.error();
  return std::unique_ptr<RecordingOutlet>(
      std::make_unique<RecorderOutlet>(place, std::move(*recorder), waits));
}

std::string EncodeJpeg(const cv::Mat& gray) {
  constexpr int kQuality = 80;
  std::vector<unsigned char> bytes;
  try {
    if (!gray.empty()) cv::imencode(".jpg", gray, bytes, {cv::IMWRITE_JPEG_QUALITY, kQuality});
  } catch (const cv::Exception&) {
    bytes.clear();
  }
  return {bytes.begin(), bytes.end()};
}

}  // namespace tagtwist::internal
