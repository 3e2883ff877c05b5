#include "estimator/publish/picture_json.h"

#include <algorithm>
#include <array>
#include <optional>
#include <vector>

#include "estimator/publish/json_text.h"
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

bool IsUsed(const PublishedFrame& frame, int id) {
  return std::find(frame.used_tags.begin(), frame.used_tags.end(), id) != frame.used_tags.end();
}

PictureNumbers::PictureNumbers(const PublishedRun& run)
    : setup_(MakeEstimatorSetup(run.set_up, EstimatorOptions())) {}

std::string PictureNumbers::WhySetAside(const PublishedFrame& frame,
                                        const TagDetection& tag) const {
  if (frame.state.status == FrameStatus::kNoFix) return "there is no state to hold it against";
  if (setup_.map.Find(tag.id) == nullptr) return "the map does not have it";
  const auto judged = JudgeTag(setup_, frame.state.state.world_from_body, tag);
  if (!judged) return "is not seen on its plane";
  if (judged->fault == TagFault::kMirrored) return "is seen mirrored";
  if (judged->fault == TagFault::kWrongId) return "is seen where the map has another tag";
  return Format("lies %.0f mm from where the map has it", 1e3 * judged->distance_m);
}

std::string PictureNumbers::Json(const PublishedFrame& frame) const {
  const bool has_state = frame.state.status != FrameStatus::kNoFix;
  const Pose cam_from_map = setup_.CameraOf(0).CamFromMap(frame.state.state.world_from_body);
  JsonText json;
  json.Open('{').Key("type").String("picture").Key("t").Raw(FormatSeconds(frame.state.t_ns));
  json.Key("width").Integer(setup_.camera.width).Key("height").Integer(setup_.camera.height);
  json.Key("status").String(ToString(frame.state.status)).Key("seen").Open('[');
  for (const TagDetection& tag : frame.tags) {
    const bool is_used = IsUsed(frame, tag.id);
    json.Open('{').Key("id").Integer(tag.id).Key("used").Truth(is_used);
    json.Key("corners").Numbers(Corners(tag), kPixelDigits);
    if (!is_used) json.Key("why").String(WhySetAside(frame, tag));
    json.Close('}');
  }
  json.Close(']').Key("map").Open('[');
  double largest_m = 0;
  for (const Tag& tag : setup_.map.tags()) {
    largest_m = std::max(largest_m, tag.size_m);
    if (!has_state) continue;
    const auto corners = Projected(setup_.camera, cam_from_map, setup_.map.CornersInWorld(tag.id));
    if (!corners) continue;
    json.Open('{').Key("id").Integer(tag.id).Key("corners").Numbers(*corners, kPixelDigits);
    AppendPoints("axes",
                 Projected(setup_.camera, cam_from_map, Axes(tag.world_from_tag, 0.5 * tag.size_m)),
                 &json);
    json.Close('}');
  }
  json.Close(']');
  std::optional<std::vector<double>> axes;
  if (has_state) axes = Projected(setup_.camera, cam_from_map, Axes(Pose(), largest_m));
  AppendPoints("world", axes, &json);
  return json.Close('}').text();
}

}  // namespace tagtwist::internal
