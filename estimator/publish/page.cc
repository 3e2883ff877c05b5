#include "estimator/publish/page.h"

#include "estimator/publish/json_text.h"
#include "frontend/base/check.h"

namespace tagtwist::internal {

// Of the files in assets/, embedded by CMake.
std::string_view LiveHtml();
std::string_view LiveCss();
std::string_view LiveJs();
std::string_view PageJs();

namespace {

// Corners in W, or in the body that they move with, which is named then.
void AppendTags(const PublishedRun& run, size_t body, JsonText* json) {
  const TagMap map = run.SetUpOf(body).map;
  for (const Tag& tag : map.tags()) {
    std::vector<double> corners;
    for (const Eigen::Vector3d& corner : map.CornersInWorld(tag.id)) {
      corners.insert(corners.end(), {corner.x(), corner.y(), corner.z()});
    }
    json->Open('{').Key("id").Integer(tag.id).Key("on");
    if (run.TagsMove(body)) json->String(run.BodyName(body));
    if (!run.TagsMove(body)) json->Null();
    json->Key("corners").Numbers(corners, 7).Close('}');
  }
}

}  // namespace

std::string WithAssets(
    std::string_view html,
    const std::vector<std::pair<std::string_view, std::string_view>>& marks_and_parts) {
  std::string out;
  for (const auto& [mark, part] : marks_and_parts) {
    const size_t at = html.find(mark);
    TAGTWIST_CHECK(at != std::string_view::npos, "a page has its marks in order");
    out.append(html.substr(0, at)).append(part);
    html.remove_prefix(at + mark.size());
  }
  return out.append(html);
}

std::string LivePage() {
  return WithAssets(
      LiveHtml(),
      {{"/*live.css*/", LiveCss()}, {"/*page.js*/", PageJs()}, {"/*live.js*/", LiveJs()}});
}

std::string SetUpJson(const PublishedRun& run, bool can_record) {
  JsonText json;
  json.Open('{').Key("type").String("setup").Key("version").String(TAGTWIST_VERSION);
  json.Key("dataset").String(run.dataset).Key("world").String(run.world);
  json.Key("can_record").Truth(can_record).Key("bodies").Open('[');
  for (size_t i = 0; i < run.n_bodies(); ++i) json.String(run.BodyName(i));
  json.Close(']').Key("cameras").Open('[');
  const bool stand = run.set_up.rig.mounted_on == MountedOn::kWorld;
  for (const RigCamera& camera : run.set_up.rig.cameras) {
    json.Open('{').Key("name").String(camera.name);
    json.Key("width").Integer(camera.camera.width).Key("height").Integer(camera.camera.height);
    json.Key("stands");  // where
    if (stand) json.Numbers(Eigen::Vector3d(Inverse(camera.cam_from_body).translation()), 7);
    if (!stand) json.Null();
    json.Close('}');
  }
  json.Close(']').Key("tags").Open('[');
  for (size_t i = 0; i < run.n_bodies(); ++i) AppendTags(run, i, &json);
  return json.Close(']').Close('}').text();
}

}  // namespace tagtwist::internal
