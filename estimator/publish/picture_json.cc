#include "estimator/publish/picture_json.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "estimator/result/tag_audit.h"
#include "frontend/base/format_text.h"
#include "frontend/base/number_text.h"

namespace tagtwist::internal {
namespace {

constexpr int kPixelDigits = 7;

// Points of the world as u v, u v, ...; nullopt where one of them is not in front of the lens, or
// all lie off the image.
template <size_t n>
std::optional<std::vector<double>> Projected(const Camera& camera, const Pose& cam_from_map,
                                             const std::array<Eigen::Vector3d, n>& points) {
  std::vector<double> out;
  bool is_seen = false;
  for (const Eigen::Vector3d& point : points) {
    Eigen::Vector2d pixel;
    if (!camera.Project(cam_from_map * point, &pixel)) return std::nullopt;
    is_seen = is_seen || camera.Contains(pixel);
    out.insert(out.end(), {pixel.x(), pixel.y()});
  }
  return is_seen ? std::optional(out) : std::nullopt;
}

// Origin and ends of x, y and z.
std::array<Eigen::Vector3d, 4> Axes(const Pose& world_from_frame, double length_m) {
  return {world_from_frame * Eigen::Vector3d::Zero(),
          world_from_frame * Eigen::Vector3d(length_m, 0, 0),
          world_from_frame * Eigen::Vector3d(0, length_m, 0),
          world_from_frame * Eigen::Vector3d(0, 0, length_m)};
}

void AppendPoints(const char* key, const std::optional<std::vector<double>>& points,
                  JsonText* json) {
  json->Key(key);
  if (points) json->Numbers(*points, kPixelDigits);
  if (!points) json->Null();
}

std::vector<double> Corners(const TagDetection& tag) {
  std::vector<double> out;
  for (const Eigen::Vector2d& corner : tag.corners) {
    out.insert(out.end(), {corner.x(), corner.y()});
  }
  return out;
}

}  // namespace

bool IsUsed(const SeenBody& body, int id) {
  return std::find(body.used_tags.begin(), body.used_tags.end(), id) != body.used_tags.end();
}

PictureNumbers::PictureNumbers(const PublishedRun& run) {
  for (const RigCamera& camera : run.set_up.rig.cameras) camera_names_.push_back(camera.name);
  for (size_t i = 0; i < run.n_bodies(); ++i) {
    setups_.push_back(MakeEstimatorSetup(run.SetUpOf(i), EstimatorOptions()));
    tags_move_.push_back(run.TagsMove(i));
  }
}

Pose PictureNumbers::PoseOver(const PublishedFrame& frame, size_t body) const {
  const Pose& world_from_body = frame.bodies[body].state.state.world_from_body;
  if (body == 0 || tags_move_.front()) return world_from_body;
  return Inverse(world_from_body) * frame.bodies.front().state.state.world_from_body;
}

std::string PictureNumbers::WhySetAside(const PublishedFrame& frame, size_t body,
                                        const TagDetection& tag) const {
  const EstimatorSetup& setup = setups_[body];
  if (frame.bodies[body].state.status == FrameStatus::kNoFix) {
    return "there is no state to hold it against";
  }
  if (setup.map.Find(tag.id) == nullptr) return "the map does not have it";
  const auto judged = JudgeTag(setup, PoseOver(frame, body), tag);
  if (!judged) return "is not seen on its plane";
  if (judged->fault == TagFault::kMirrored) return "is seen mirrored";
  if (judged->fault == TagFault::kWrongId) return "is seen where the map has another tag";
  return Format("lies %.0f mm from where the map has it", 1e3 * judged->distance_m);
}

void PictureNumbers::AppendSeen(const PublishedFrame& frame, size_t camera, JsonText* json) const {
  for (size_t i = 0; i < frame.bodies.size(); ++i) {
    for (const TagDetection& tag : frame.bodies[i].tags) {
      if (tag.camera != static_cast<int>(camera)) continue;
      const bool is_used = IsUsed(frame.bodies[i], tag.id);
      json->Open('{').Key("id").Integer(tag.id).Key("used").Truth(is_used);
      json->Key("corners").Numbers(Corners(tag), kPixelDigits);
      if (!is_used) json->Key("why").String(WhySetAside(frame, i, tag));
      json->Close('}');
    }
  }
}

void PictureNumbers::AppendTags(const PublishedFrame& frame, size_t camera, size_t body,
                                JsonText* json) const {
  if (frame.bodies[body].state.status == FrameStatus::kNoFix) return;
  const EstimatorSetup& setup = setups_[body];
  const MountedCamera mounted = setup.CameraOf(static_cast<int>(camera));
  const Pose cam_from_map = mounted.CamFromMap(PoseOver(frame, body));
  for (const Tag& tag : setup.map.tags()) {
    const auto corners = Projected(mounted.camera, cam_from_map, setup.map.CornersInWorld(tag.id));
    if (!corners) continue;
    json->Open('{').Key("id").Integer(tag.id).Key("corners").Numbers(*corners, kPixelDigits);
    AppendPoints(
        "axes", Projected(mounted.camera, cam_from_map, Axes(tag.world_from_tag, 0.5 * tag.size_m)),
        json);
    json->Close('}');
  }
}

std::string PictureNumbers::Json(const PublishedFrame& frame, size_t camera) const {
  const Camera shown = setups_.front().CameraOf(static_cast<int>(camera)).camera;
  JsonText json;
  json.Open('{').Key("type").String("picture").Key("t").Raw(FormatSeconds(frame.t_ns()));
  json.Key("camera").String(camera_names_.at(camera));
  json.Key("width").Integer(shown.width).Key("height").Integer(shown.height);
  json.Key("seen").Open('[');
  AppendSeen(frame, camera, &json);
  json.Close(']').Key("map").Open('[');
  for (size_t i = 0; i < frame.bodies.size(); ++i) AppendTags(frame, camera, i, &json);
  json.Close(']').Key("frames").Open('[');
  for (size_t i = 0; i < frame.bodies.size(); ++i) {
    if (frame.bodies[i].state.status == FrameStatus::kNoFix) continue;
    const MountedCamera mounted = setups_[i].CameraOf(static_cast<int>(camera));
    double largest_m = 0;
    for (const Tag& tag : setups_[i].map.tags()) largest_m = std::max(largest_m, tag.size_m);
    const auto axes =
        Projected(mounted.camera, mounted.CamFromMap(PoseOver(frame, i)), Axes(Pose(), largest_m));
    if (axes) json.Numbers(*axes, kPixelDigits);
  }
  return json.Close(']').Close('}').text();
}

}  // namespace tagtwist::internal
