#include "estimator/publish/page.h"

#include <string_view>
#include <vector>

#include "estimator/publish/json_text.h"

namespace tagtwist::internal {

// Of the files in assets/, embedded by CMake.
std::string_view LiveHtml();
std::string_view LiveCss();
std::string_view LiveJs();

namespace {

// The text with the first `mark` replaced.
std::string With(const std::string& text, const std::string& mark, std::string_view by) {
  const size_t at = text.find(mark);
  return text.substr(0, at) + std::string(by) + text.substr(at + mark.size());
}

}  // namespace

std::string LivePage() {
  const std::string html(LiveHtml());
  return With(With(html, "/*live.css*/", LiveCss()), "/*live.js*/", LiveJs());
}

std::string SetUpJson(const PublishedRun& run, bool can_record) {
  const RigCamera& camera = run.set_up.rig.front();
  JsonText json;
  json.Open('{').Key("type").String("setup").Key("version").String(TAGTWIST_VERSION);
  json.Key("dataset").String(run.dataset).Key("body").String(run.body);
  json.Key("world").String(run.world).Key("can_record").Truth(can_record);
  json.Key("camera").Open('{').Key("name").String(camera.name);
  json.Key("width").Integer(camera.camera.width).Key("height").Integer(camera.camera.height);
  json.Close('}').Key("tags").Open('[');
  for (const Tag& tag : run.set_up.map.tags()) {
    std::vector<double> corners;
    for (const Eigen::Vector3d& corner : run.set_up.map.CornersInWorld(tag.id)) {
      corners.insert(corners.end(), {corner.x(), corner.y(), corner.z()});
    }
    json.Open('{').Key("id").Integer(tag.id).Key("corners").Numbers(corners, 7).Close('}');
  }
  return json.Close(']').Close('}').text();
}

}  // namespace tagtwist::internal
