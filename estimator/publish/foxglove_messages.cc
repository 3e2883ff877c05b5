#include "estimator/publish/foxglove_messages.h"

#include "estimator/publish/json_text.h"
#include "estimator/publish/state_json.h"

namespace tagtwist::internal {
namespace {

const char* const kPoseSchema = R"({"title":"foxglove.PoseInFrame","type":"object","properties":{
"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},
"frame_id":{"type":"string"},"pose":{"type":"object","title":"foxglove.Pose","properties":{
"position":{"type":"object","title":"foxglove.Vector3","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}},
"orientation":{"type":"object","title":"foxglove.Quaternion","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"},"w":{"type":"number"}}}}}}})";

const char* const kTransformsSchema =
    R"({"title":"foxglove.FrameTransforms","type":"object","properties":{"transforms":{"type":"array","items":{
"title":"foxglove.FrameTransform","type":"object","properties":{
"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},
"parent_frame_id":{"type":"string"},"child_frame_id":{"type":"string"},
"translation":{"type":"object","title":"foxglove.Vector3","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}},
"rotation":{"type":"object","title":"foxglove.Quaternion","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"},"w":{"type":"number"}}}}}}}})";

const char* const kTwistSchema = R"({"title":"tagtwist.Twist","type":"object","properties":{
"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},
"linear_frame_id":{"type":"string"},"angular_frame_id":{"type":"string"},
"linear":{"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}},
"angular":{"type":"object","properties":{"x":{"type":"number"},"y":{"type":"number"},"z":{"type":"number"}}}}})";

const char* const kImageSchema =
    R"({"title":"foxglove.CompressedImage","type":"object","properties":{
"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},
"frame_id":{"type":"string"},"data":{"type":"string","contentEncoding":"base64"},"format":{"type":"string"}}})";

// Only what MapMessage fills is described; the others are empty lists.
const char* const kSceneSchema = R"({"title":"foxglove.SceneUpdate","type":"object","properties":{
"deletions":{"type":"array","items":{"type":"object"}},"entities":{"type":"array","items":{"title":"foxglove.SceneEntity","type":"object","properties":{
"timestamp":{"type":"object","title":"time","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},
"frame_id":{"type":"string"},"id":{"type":"string"},
"lifetime":{"type":"object","title":"duration","properties":{"sec":{"type":"integer"},"nsec":{"type":"integer"}}},
"frame_locked":{"type":"boolean"},
"lines":{"type":"array","items":{"title":"foxglove.LinePrimitive","type":"object"}},
"texts":{"type":"array","items":{"title":"foxglove.TextPrimitive","type":"object"}}}}}}})";

void AppendVector(const Eigen::Vector3d& v, JsonText* json) {
  json->Open('{');
  for (int i = 0; i < 3; ++i)
    json->Key(i == 0 ? "x" : i == 1 ? "y" : "z").Number(v(i), kStateDigits);
  json->Close('}');
}

void AppendQuaternion(const Pose& pose, JsonText* json) {
  const Eigen::Vector4d q = QuaternionOf(pose);
  json->Open('{').Key("x").Number(q(0), kStateDigits).Key("y").Number(q(1), kStateDigits);
  json->Key("z").Number(q(2), kStateDigits).Key("w").Number(q(3), kStateDigits).Close('}');
}

void AppendPose(const Pose& pose, JsonText* json) {
  json->Open('{').Key("position");
  AppendVector(pose.translation(), json);
  json->Key("orientation");
  AppendQuaternion(pose, json);
  json->Close('}');
}

void AppendTransform(int64_t t_ns, const std::string& parent, const std::string& child,
                     const Pose& parent_from_child, JsonText* json) {
  json->Open('{').Key("timestamp");
  AppendStamp(t_ns, json);
  json->Key("parent_frame_id").String(parent).Key("child_frame_id").String(child);
  json->Key("translation");
  AppendVector(parent_from_child.translation(), json);
  json->Key("rotation");
  AppendQuaternion(parent_from_child, json);
  json->Close('}');
}

void AppendColour(double r, double g, double b, JsonText* json) {
  json->Key("color").Open('{').Key("r").Number(r, 3).Key("g").Number(g, 3);
  json->Key("b").Number(b, 3).Key("a").Number(1, 3).Close('}');
}

// The outlines of all tags as one primitive: a list of single lines.
void AppendOutlines(const TagMap& map, JsonText* json) {
  constexpr int kLineList = 2;
  json->Open('{').Key("type").Integer(kLineList).Key("pose");
  AppendPose(Pose(), json);
  json->Key("thickness").Number(2, 3).Key("scale_invariant").Truth(true);
  json->Key("points").Open('[');
  for (const Tag& tag : map.tags()) {
    const auto& corners = map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      AppendVector(corners[c], json);
      AppendVector(corners[(c + 1) % 4], json);
    }
  }
  json->Close(']');
  AppendColour(0.5, 0.55, 0.6, json);
  json->Key("colors").Open('[').Close(']').Key("indices").Open('[').Close(']').Close('}');
}

void AppendIds(const TagMap& map, JsonText* json) {
  for (const Tag& tag : map.tags()) {
    json->Open('{').Key("pose");
    AppendPose(tag.world_from_tag, json);
    json->Key("billboard").Truth(false).Key("font_size").Number(0.5 * tag.size_m, 4);
    json->Key("scale_invariant").Truth(false);
    AppendColour(0.5, 0.55, 0.6, json);
    json->Key("text").String(std::to_string(tag.id)).Close('}');
  }
}

std::string PoseJson(const PublishedRun& run, const FrameEstimate& state) {
  JsonText json;
  json.Open('{').Key("timestamp");
  AppendStamp(state.t_ns, &json);
  json.Key("frame_id").String(run.world).Key("pose");
  AppendPose(state.state.world_from_body, &json);
  return json.Close('}').text();
}

bool HasState(const SeenBody& body) { return body.state.status != FrameStatus::kNoFix; }

std::string TransformsJson(const PublishedRun& run, const PublishedFrame& frame) {
  JsonText json;
  json.Open('{').Key("transforms").Open('[');
  for (size_t i = 0; i < frame.bodies.size(); ++i) {
    if (!HasState(frame.bodies[i])) continue;
    AppendTransform(frame.t_ns(), run.world, run.BodyName(i),
                    frame.bodies[i].state.state.world_from_body, &json);
  }
  const Rig& rig = run.set_up.rig;
  for (const RigCamera& camera : rig.cameras) {
    AppendTransform(frame.t_ns(), rig.mounted_on == MountedOn::kBody ? run.body : run.world,
                    camera.name, Inverse(camera.cam_from_body), &json);
  }
  return json.Close(']').Close('}').text();
}

std::string TwistJson(const PublishedRun& run, size_t body, const FrameEstimate& state) {
  JsonText json;
  json.Open('{').Key("timestamp");
  AppendStamp(state.t_ns, &json);
  json.Key("linear_frame_id").String(run.world).Key("angular_frame_id").String(run.BodyName(body));
  json.Key("linear");
  AppendVector(state.state.twist.v_world, &json);
  json.Key("angular");
  AppendVector(state.state.twist.omega_body, &json);
  return json.Close('}').text();
}

void AppendEntity(int64_t t_ns, const std::string& frame_id, const std::string& id,
                  const TagMap& map, JsonText* json) {
  json->Open('{').Key("timestamp");
  AppendStamp(t_ns, json);
  json->Key("frame_id").String(frame_id).Key("id").String(id).Key("lifetime");
  AppendStamp(0, json);
  json->Key("frame_locked").Truth(true);
  for (const char* key :
       {"metadata", "arrows", "cubes", "spheres", "cylinders", "triangles", "models"}) {
    json->Key(key).Open('[').Close(']');
  }
  json->Key("lines").Open('[');
  AppendOutlines(map, json);
  json->Close(']').Key("texts").Open('[');
  AppendIds(map, json);
  json->Close(']').Close('}');
}

}  // namespace

uint32_t ChannelOf(size_t body, OfBody what) {
  return static_cast<uint32_t>(kMap + 1 + 3 * body) + static_cast<uint32_t>(what);
}

uint32_t ImageChannel(const PublishedRun& run, size_t camera) {
  return ChannelOf(run.n_bodies(), OfBody::kState) + static_cast<uint32_t>(camera);
}

std::vector<FoxgloveChannel> FoxgloveChannels(const PublishedRun& run) {
  const std::string all = "/tagtwist/";
  std::vector<FoxgloveChannel> out = {
      {kTransforms, "/tf", "foxglove.FrameTransforms", kTransformsSchema},
      {kMap, all + "map", "foxglove.SceneUpdate", kSceneSchema, true}};
  for (size_t i = 0; i < run.n_bodies(); ++i) {
    const std::string topic = all + run.BodyName(i);
    out.push_back(
        {ChannelOf(i, OfBody::kState), topic + "/state", "tagtwist.State", StateSchema()});
    out.push_back(
        {ChannelOf(i, OfBody::kPose), topic + "/pose", "foxglove.PoseInFrame", kPoseSchema});
    out.push_back({ChannelOf(i, OfBody::kTwist), topic + "/twist", "tagtwist.Twist", kTwistSchema});
  }
  const Rig& rig = run.set_up.rig;
  const std::string of = rig.mounted_on == MountedOn::kBody ? all + run.body + "/" : all;
  for (size_t i = 0; i < rig.cameras.size(); ++i) {
    out.push_back({ImageChannel(run, i), of + rig.cameras[i].name + "/image",
                   "foxglove.CompressedImage", kImageSchema, true});
  }
  return out;
}

std::vector<FoxgloveMessage> NumberMessages(const PublishedRun& run, const PublishedFrame& frame,
                                            const std::vector<std::string>& state_jsons) {
  std::vector<FoxgloveMessage> out;
  bool any = false;
  for (size_t i = 0; i < frame.bodies.size(); ++i) {
    const FrameEstimate& state = frame.bodies[i].state;
    out.push_back({ChannelOf(i, OfBody::kState), state.t_ns, state_jsons[i]});
    if (!HasState(frame.bodies[i])) continue;
    any = true;
    out.push_back({ChannelOf(i, OfBody::kPose), state.t_ns, PoseJson(run, state)});
    out.push_back({ChannelOf(i, OfBody::kTwist), state.t_ns, TwistJson(run, i, state)});
  }
  if (any) out.push_back({kTransforms, frame.t_ns(), TransformsJson(run, frame)});
  return out;
}

FoxgloveMessage ImageMessage(const PublishedRun& run, size_t camera, int64_t t_ns,
                             std::string_view jpeg) {
  JsonText json;
  json.Open('{').Key("timestamp");
  AppendStamp(t_ns, &json);
  json.Key("frame_id").String(run.set_up.rig.cameras.at(camera).name);
  json.Key("format").String("jpeg");
  json.Key("data").Raw('"' + Base64(jpeg) + '"');
  return {ImageChannel(run, camera), t_ns, json.Close('}').text()};
}

FoxgloveMessage MapMessage(const PublishedRun& run, int64_t t_ns) {
  JsonText json;
  json.Open('{').Key("deletions").Open('[').Close(']').Key("entities").Open('[');
  for (size_t i = 0; i < run.n_bodies(); ++i) {
    const bool moves = run.TagsMove(i);
    AppendEntity(t_ns, moves ? run.BodyName(i) : run.world, i == 0 ? "map" : run.BodyName(i),
                 run.SetUpOf(i).map, &json);
  }
  return {kMap, t_ns, json.Close(']').Close('}').text()};
}

std::string Base64(std::string_view bytes) {
  static constexpr std::string_view kLetters =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t three = 0;
    for (size_t k = 0; k < 3; ++k) {
      const char c = i + k < bytes.size() ? bytes[i + k] : '\0';
      three = three << 8 | static_cast<unsigned char>(c);
    }
    for (size_t k = 0; k < 4; ++k) {
      out += i + k > bytes.size() ? '=' : kLetters[three >> (18 - 6 * k) & 63];
    }
  }
  return out;
}

}  // namespace tagtwist::internal
