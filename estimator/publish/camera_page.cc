#include "estimator/publish/camera_page.h"

#include <string_view>
#include <utility>

#include "estimator/calibration/lens/lens_numbers.h"
#include "estimator/publish/json_text.h"
#include "estimator/publish/outlets.h"
#include "estimator/publish/page.h"
#include "frontend/base/number_text.h"

namespace tagtwist::internal {

// Of the files in assets/, embedded by CMake.
std::string_view CameraHtml();
std::string_view CameraJs();
std::string_view LiveCss();
std::string_view PageJs();

namespace {

constexpr int kCornerDigits = 7, kValueDigits = 9, kShownDigits = 3;

std::string PictureJson(const GuideView& view) {
  JsonText json;
  json.Open('{').Key("type").String("picture").Key("t").Raw(FormatSeconds(view.t_ns));
  json.Key("width").Integer(view.image.cols).Key("height").Integer(view.image.rows);
  json.Key("seen").Open('[');
  for (const TagDetection& tag : view.tags) {
    json.Open('{').Key("id").Integer(tag.id).Key("corners").Open('[');
    for (const Eigen::Vector2d& corner : tag.corners) {
      json.Number(corner.x(), kCornerDigits).Number(corner.y(), kCornerDigits);
    }
    json.Close(']').Close('}');
  }
  return json.Close(']').Close('}').text();
}

void AppendNumbers(const LensFound& found, JsonText* json) {
  json->Open('[');
  for (const LensNumber& number : NumbersOf(found)) {
    json->Open('{').Key("name").String(number.name).Key("unit").String(number.unit);
    json->Key("value").Number(number.value, kValueDigits);
    json->Key("sigma").Number(number.sigma, kShownDigits).Close('}');
  }
  json->Close(']');
}

std::string VerdictJson(const CameraVerdictToShow& verdict) {
  JsonText json;
  json.Open('{').Key("good").Truth(verdict.is_good).Key("text").String(verdict.text);
  return json.Close('}').text();
}

}  // namespace

std::string CameraPageHtml() {
  return WithAssets(
      CameraHtml(),
      {{"/*live.css*/", LiveCss()}, {"/*page.js*/", PageJs()}, {"/*camera.js*/", CameraJs()}});
}

Result<std::unique_ptr<CameraPage>> CameraPage::Start(const Options& options) {
  const auto place = WebPlaceOf(options.listen);
  if (!place) return place.error();
  std::unique_ptr<CameraPage> out(new CameraPage());
  out->place_ = *place;
  WebServer::Options web;
  web.address = place->address;
  web.token = place->token;
  web.port = options.port;
  web.page = CameraPageHtml();
  JsonText greeting;
  greeting.Open('{').Key("type").String("setup").Key("recording").String(options.recording);
  greeting.Key("columns").Integer(ViewsJudged::kColumns).Key("rows").Integer(ViewsJudged::kRows);
  web.greeting = greeting.Close('}').text();
  auto server = WebServer::Start(std::move(web));
  if (!server) return server.error();
  out->server_ = std::move(*server);
  const auto raw = out.get();
  out->worker_ = std::make_unique<Worker<std::shared_ptr<const GuideView>>>(
      1, false, [raw](const std::shared_ptr<const GuideView>& view) { raw->Send(*view); });
  return out;
}

CameraPage::~CameraPage() = default;

std::string CameraPage::Link() const {
  return "page       http://" + LinkTo(place_, server_->port());
}

void CameraPage::Show(const GuideView& view) {
  worker_->Push(std::make_shared<const GuideView>(view));
}

void CameraPage::Send(const GuideView& view) {
  if (view.lens != nullptr && (known_.empty() || known_.back().lens != view.lens)) {
    known_.push_back({view.kept, view.lens});
  }
  last_ = view;
  if (server_->HasPages()) server_->SendPicture(0, PictureJson(view), EncodeJpeg(view.image));
  SendFacts(view, "null");
}

void CameraPage::SendFacts(const GuideView& view, const std::string& verdict_json) {
  JsonText json;
  json.Open('{').Key("type").String("facts");
  json.Key("kept").Integer(static_cast<int64_t>(view.kept)).Key("words").String(view.words);
  json.Key("calibrating").Truth(view.is_calibrating).Key("verdict").Raw(verdict_json);
  json.Key("covered").Number(view.seen.covered(), kShownDigits).Key("cells").Open('[');
  for (const int n : view.seen.corners) json.Integer(n);
  json.Close(']').Key("known").Open('[');
  for (const Known& known : known_) {
    json.Open('{').Key("kept").Integer(static_cast<int64_t>(known.kept)).Key("numbers");
    AppendNumbers(*known.lens, &json);
    json.Close('}');
  }
  server_->SendFacts(json.Close(']').Close('}').text());
}

void CameraPage::End(const CameraVerdictToShow& verdict) {
  worker_->Finish();
  GuideView view = last_;
  view.is_calibrating = false;
  view.words.clear();
  if (verdict.found != nullptr) {
    view.lens = verdict.found;
    view.seen = verdict.found->views;
    if (known_.empty() || known_.back().lens != view.lens) known_.push_back({view.kept, view.lens});
  }
  SendFacts(view, VerdictJson(verdict));
}

}  // namespace tagtwist::internal
