#include "estimator/publish/state_json.h"

#include <vector>

#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

void AppendState(const FrameEstimate& state, JsonText* json) {
  const Pose& pose = state.state.world_from_body;
  json->Key("position").Numbers(Eigen::Vector3d(pose.translation()), kStateDigits);
  json->Key("orientation").Numbers(QuaternionOf(pose), kStateDigits);
  json->Key("linear_velocity").Numbers(state.state.twist.v_world, kStateDigits);
  json->Key("angular_velocity").Numbers(state.state.twist.omega_body, kStateDigits);
  json->Key("sigma").Numbers(StateVector(state.covariance.diagonal().cwiseSqrt()), kSigmaDigits);
  json->Key("covariance").Open('[');
  for (int i = 0; i < 12; ++i) {
    for (int j = i; j < 12; ++j) json->Number(state.covariance(i, j), kCovarianceDigits);
  }
  json->Close(']');
}

}  // namespace

void AppendStamp(int64_t t_ns, JsonText* json) {
  constexpr int64_t kSecond = 1'000'000'000;
  int64_t sec = t_ns / kSecond, nsec = t_ns % kSecond;
  if (nsec < 0) --sec, nsec += kSecond;
  json->Open('{').Key("sec").Integer(sec).Key("nsec").Integer(nsec).Close('}');
}

Eigen::Vector4d QuaternionOf(const Pose& pose) {
  return (pose.params(3) < 0 ? -1 : 1) * pose.params.head<4>();
}

std::string StateJson(const PublishedRun& run, const PublishedFrame& frame, size_t body) {
  const FrameEstimate& state = frame.bodies[body].state;
  JsonText json;
  json.Open('{').Key("type").String("state");
  json.Key("body").String(run.BodyName(body)).Key("world").String(run.world);
  json.Key("cameras").Open('[');
  for (const CameraImage& image : frame.images) {
    json.String(run.set_up.rig.cameras.at(static_cast<size_t>(image.camera)).name);
  }
  json.Close(']');
  json.Key("t").Raw(FormatSeconds(state.t_ns)).Key("stamp");
  AppendStamp(state.t_ns, &json);
  json.Key("status").String(ToString(state.status));
  if (state.status != FrameStatus::kNoFix) {
    AppendState(state, &json);
  } else {
    for (const char* key : {"position", "orientation", "linear_velocity", "angular_velocity",
                            "sigma", "covariance"}) {
      json.Key(key).Null();
    }
  }
  json.Key("n_tags").Integer(state.n_tags).Key("n_tracks").Integer(state.n_tracks);
  json.Key("latency_ms").Number(frame.latency_ms, 5);
  json.Key("frames_dropped").Integer(static_cast<int64_t>(frame.frames_dropped));
  return json.Close('}').text();
}

std::vector<std::string> StateJsons(const PublishedRun& run, const PublishedFrame& frame) {
  std::vector<std::string> out;
  for (size_t i = 0; i < frame.bodies.size(); ++i) out.push_back(StateJson(run, frame, i));
  return out;
}

std::string StateSchema() {
  JsonText json;
  json.Open('{').Key("type").String("object").Key("title").String("tagtwist.State");
  json.Key("properties").Open('{');
  for (const char* key : {"type", "body", "world", "status"}) {
    json.Key(key).Raw(R"({"type":"string"})");
  }
  json.Key("cameras").Raw(R"({"type":"array","items":{"type":"string"}})");
  json.Key("stamp").Raw(
      R"({"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}})");
  for (const char* key : {"t", "n_tags", "n_tracks", "latency_ms", "frames_dropped"}) {
    json.Key(key).Raw(R"({"type":"number"})");
  }
  for (const char* key :
       {"position", "orientation", "linear_velocity", "angular_velocity", "sigma", "covariance"}) {
    json.Key(key).Raw(R"({"type":"array","items":{"type":"number"}})");
  }
  return json.Close('}').Close('}').text();
}

}  // namespace tagtwist::internal
