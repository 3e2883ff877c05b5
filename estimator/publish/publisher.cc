#include "estimator/publish/publisher.h"

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "estimator/publish/foxglove_messages.h"
#include "estimator/publish/live_verdict.h"
#include "estimator/publish/outlets.h"
#include "estimator/publish/page.h"
#include "estimator/publish/picture_json.h"
#include "estimator/publish/state_json.h"
#include "estimator/publish/udp_sender.h"
#include "estimator/publish/web/web_place.h"
#include "estimator/publish/web/web_server.h"
#include "estimator/publish/worker.h"

namespace tagtwist::internal {
namespace {

using Clock = std::chrono::steady_clock;

constexpr size_t kMostUnsent = 64;                                // that wait to be sent
constexpr auto kBetweenPictures = std::chrono::milliseconds(40);  // for pages
constexpr auto kBetweenFacts = std::chrono::milliseconds(500);

class ThreadedPublisher : public Publisher {
 public:
  ThreadedPublisher(const PublishOptions& options, const PublishedRun& run)
      : options_(options),
        run_(run),
        picture_numbers_(run),
        verdicts_(run),
        last_pictures_(run.set_up.rig.cameras.size()) {}
  ~ThreadedPublisher() override { EndThreads(); }

  Status Open() {
    if (const Status named = run_.CheckNames(); !named) return named;
    for (const std::string& place : options_.udp) {
      auto sender = UdpSender::Open(place);
      if (!sender) return sender.error();
      udp_.push_back(std::move(*sender));
    }
    if (!options_.mcap.empty()) {
      auto outlet = OpenMcapOutlet(options_.mcap, run_, options_.waits);
      if (!outlet) return outlet.error();
      mcap_ = std::move(*outlet);
    }
    if (!options_.record.empty()) {
      auto recording = OpenRecording(options_.record, run_.set_up.rig, options_.waits);
      if (!recording) return recording.error();
      recording_ = std::move(*recording);
    }
    if (options_.page || options_.foxglove) {
      if (const Status open = OpenServer(); !open) return open;
    }
    if (server_ || !udp_.empty()) {
      numbers_.emplace(kMostUnsent, false, [this](const FramePtr& frame) { SendNumbers(*frame); });
    }
    if (server_) {
      constexpr int kPictureNiceness = 5;  // what is known of the frame goes first
      pictures_.emplace(
          1, false, [this](const FramePtr& frame) { SendPictures(*frame); }, kPictureNiceness);
    }
    return Ok();
  }

  void Publish(FramePtr frame) override {
    if (numbers_) numbers_->Push(frame);
    if (pictures_) pictures_->Push(frame);
    if (mcap_) mcap_->Push(frame);
    if (recording_) recording_->Push(frame);
  }

  std::vector<std::string> Links() const override {
    std::vector<std::string> out;
    if (!server_) return out;
    const std::string place = LinkTo(place_, server_->port());
    if (options_.page) out.push_back("page       http://" + place);
    if (options_.foxglove) out.push_back("foxglove   ws://" + place);
    return out;
  }

  Losses Finish() override {
    EndThreads();
    Losses out;
    for (size_t i = 0; i < udp_.size(); ++i) {
      Count("udp://" + options_.udp[i], udp_[i]->lost(), &out);
    }
    for (const auto& [name, outlet] :
         {std::pair<std::string, Outlet*>("mcap:" + options_.mcap, mcap_.get()),
          {"--record " + options_.record, recording_.get()}}) {
      if (outlet == nullptr) continue;
      const std::string problem = outlet->Finish();
      if (out.failure.empty()) out.failure = problem;
      Count(name, outlet->dropped(), &out);
    }
    return out;
  }

 private:
  static void Count(const std::string& name, size_t dropped, Losses* out) {
    if (dropped == 0) return;
    out->warnings.push_back(name + " lacks " + std::to_string(dropped) +
                            (dropped == 1 ? " frame" : " frames") + ": it could not keep up");
  }

  Status OpenServer() {
    const auto place = WebPlaceOf(options_.listen);
    if (!place) return place.error();
    place_ = *place;
    WebServer::Options web;
    web.address = place_.address;
    web.port = options_.port;
    web.token = place_.token;
    if (options_.page) web.page = LivePage();
    web.greeting = SetUpJson(run_, recording_ != nullptr);
    web.foxglove = options_.foxglove;
    web.channels = FoxgloveChannels(run_);
    web.map = MapMessage(run_, 0);
    web.on_page_text = [this](const std::string& text) { TakeFromPage(text); };
    auto server = WebServer::Start(std::move(web));
    if (!server) return server.error();
    server_ = std::move(*server);
    return Ok();
  }

  // {"type": "record", "on": true}; all else is passed over.
  void TakeFromPage(const std::string& text) {
    const auto said = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (!said.is_object() || said.value("type", nlohmann::json()) != "record") return;
    const auto on = said.value("on", nlohmann::json());
    if (on.is_boolean() && recording_) recording_->Switch(on.get<bool>());
  }

  void SendNumbers(const PublishedFrame& frame) {
    const std::vector<std::string> jsons = StateJsons(run_, frame);
    for (const std::string& json : jsons) {
      if (server_ && options_.page) server_->SendState(json);
      for (const auto& sender : udp_) sender->Send(json);
    }
    if (!server_ || !options_.foxglove) return;
    bool is_wanted = false;
    for (uint32_t channel = 1; channel < ImageChannel(run_, 0); ++channel) {
      is_wanted = is_wanted || (channel != kMap && server_->HasSubscriber(channel));
    }
    if (!is_wanted) return;
    for (FoxgloveMessage& message : NumberMessages(run_, frame, jsons)) {
      if (server_->HasSubscriber(message.channel)) server_->SendFoxglove(std::move(message));
    }
  }

  void SendPictures(const PublishedFrame& frame) {
    verdicts_.Add(frame, picture_numbers_);
    for (const CameraImage& image : frame.images) SendPicture(frame, image);
    if (options_.page && IsDue(kBetweenFacts, &last_facts_)) {
      server_->SendFacts(verdicts_.FactsJson(frame, recording_ ? recording_->Json() : "null"));
    }
  }

  void SendPicture(const PublishedFrame& frame, const CameraImage& image) {
    const auto camera = static_cast<size_t>(image.camera);
    const bool to_pages =
        options_.page && server_->HasPages() && IsDue(kBetweenPictures, &last_pictures_[camera]);
    const bool to_foxglove =
        options_.foxglove && server_->HasSubscriber(ImageChannel(run_, camera));
    if (!to_pages && !to_foxglove) return;
    std::string jpeg = EncodeJpeg(image.image);
    if (to_foxglove && !jpeg.empty()) {
      server_->SendFoxglove(ImageMessage(run_, camera, frame.t_ns(), jpeg));
    }
    if (to_pages) {
      server_->SendPicture(camera, picture_numbers_.Json(frame, camera), std::move(jpeg));
    }
  }

  static bool IsDue(Clock::duration between, Clock::time_point* last) {
    const auto now = Clock::now();
    if (now - *last < between) return false;
    *last = now;
    return true;
  }

  void EndThreads() {
    if (numbers_) numbers_->Finish();
    if (pictures_) pictures_->Finish();
    server_.reset();
  }

  PublishOptions options_;
  PublishedRun run_;
  WebPlace place_;
  PictureNumbers picture_numbers_;
  LiveVerdicts verdicts_;
  std::vector<Clock::time_point> last_pictures_;  // of each camera
  Clock::time_point last_facts_;
  std::vector<std::unique_ptr<UdpSender>> udp_;
  std::unique_ptr<Outlet> mcap_;
  std::unique_ptr<RecordingOutlet> recording_;
  std::unique_ptr<WebServer> server_;  // after what a page may switch
  std::optional<Worker<FramePtr>> numbers_, pictures_;
};

}  // namespace

Result<std::unique_ptr<Publisher>> Publisher::Start(const PublishOptions& options,
                                                    const PublishedRun& run) {
  auto out = std::make_unique<ThreadedPublisher>(options, run);
  if (const Status open = out->Open(); !open) return open.error();
  return std::unique_ptr<Publisher>(std::move(out));
}

}  // namespace tagtwist::internal
