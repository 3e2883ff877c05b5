#include "estimator/publish/outlets.h"

#include <filesystem>
#include <functional>
#include <opencv2/imgcodecs.hpp>
#include <utility>

#include "estimator/publish/foxglove_messages.h"
#include "estimator/publish/json_text.h"
#include "estimator/publish/state_json.h"
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
      problem_.Take(writer_->Write(MapMessage(run_, frame.state.t_ns)));
    }
    for (const FoxgloveMessage& message : NumberMessages(run_, frame, StateJson(run_, frame))) {
      problem_.Take(writer_->Write(message));
    }
    const std::string jpeg = EncodeJpeg(frame.image);
    if (jpeg.empty()) return;
    problem_.Take(writer_->Write(ImageMessage(run_, frame.state.t_ns, jpeg)));
  }

  PublishedRun run_;
  std::unique_ptr<McapWriter> writer_;
  bool has_map_ = false;
  Problem problem_;
  Worker<FramePtr> worker_;  // last member: it uses the others
};

// What a recording goes to.
struct Recorder {
  std::function<Status(int64_t t_ns, const cv::Mat& gray)> add;
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
              const Status added = recorder_.add(frame->state.t_ns, frame->image);
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

// A frame without an image is a row of the folder's table, and nothing in a video.
Result<Recorder> OpenRecorder(const std::string& place) {
  if (std::filesystem::path(place).extension() == ".mkv") {
    auto opened = LosslessVideo::Create(place);
    if (!opened) return opened.error();
    const std::shared_ptr<LosslessVideo> video = std::move(*opened);
    return Recorder{[video](int64_t t_ns, const cv::Mat& gray) {
                      return gray.empty() ? Ok() : video->Add(t_ns, gray);
                    },
                    [video] { return video->Finish(); }};
  }
  auto opened = ImageRecorder::Create(place);
  if (!opened) return opened.error();
  const std::shared_ptr<ImageRecorder> folder = std::move(*opened);
  return Recorder{[folder](int64_t t_ns, const cv::Mat& gray) { return folder->Add(t_ns, gray); },
                  [] { return Ok(); }};
}

}  // namespace

Result<std::unique_ptr<Outlet>> OpenMcapOutlet(const std::string& path, const PublishedRun& run,
                                               bool waits) {
  auto writer = McapWriter::Create(path, FoxgloveChannels(run));
  if (!writer) return writer.error();
  return std::unique_ptr<Outlet>(std::make_unique<McapOutlet>(std::move(*writer), run, waits));
}

Result<std::unique_ptr<RecordingOutlet>> OpenRecording(const std::string& place, bool waits) {
  auto recorder = OpenRecorder(place);
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
