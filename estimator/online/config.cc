#include "estimator/online/config.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "frontend/io/setup/camera_file.h"
#include "frontend/io/setup/camera_section.h"
#include "frontend/io/setup/tag_map_reader.h"
#include "frontend/io/setup/yaml_reader.h"

namespace tagtwist {

using namespace internal;
namespace {

// Seed Eq. 1.
Pose CourseCamFromBody() {
  const double c = std::sqrt(0.5);
  Eigen::Matrix3d rotation;
  rotation << c, -c, 0, -c, -c, 0, 0, 0, -1;
  return MakePose(Eigen::Quaterniond(rotation), {-0.04, 0, -0.03});
}

// A file named in another one, relative to that one's folder.
std::string BesideFile(const std::string& file, const std::string& name) {
  return (std::filesystem::path(file).parent_path() / name).string();
}

// Sets the camera and, unless the configuration has one, the mount.
Status TakeCamera(const std::string& path, const std::string& name, bool has_mount,
                  Config* config) {
  const Result<CameraFile> file = ReadCameraFile(path, name, config->limits);
  if (!file) return file.error();
  RigCamera& camera = config->set_up.rig.front();
  camera.camera = file->camera;
  camera.line_time_s = file->line_time_s;
  SetUpOrigins& origins = config->origins;
  origins.camera = path + (name.empty() ? "" : ", " + name);
  origins.notes = file->notes;
  if (has_mount && file->cam_from_body) {
    origins.notes.push_back(path + ": its mount, " + file->mount_key +
                            ", is not used: the configuration has cam_from_body");
  }
  if (has_mount) return Ok();
  camera.cam_from_body = file->cam_from_body.value_or(Pose());
  origins.mount =
      file->cam_from_body ? file->mount_key + " of " + path : "none given: the camera is the body";
  return Ok();
}

Status ReadCamera(const YamlValue& node, bool has_mount, Config* config) {
  YamlSection section(node);
  std::string file, name;
  section("file", file);
  if (file.empty()) {
    RigCamera& camera = config->set_up.rig.front();
    camera.camera = Camera();
    ReadCameraKeys(&section, &camera.camera);
    ReadLineTime(&section, &camera.line_time_s);
    config->origins.camera = node.file;
    return section.Finish();
  }
  section("name", name);
  if (Status status = section.Finish(); !status) return status;
  return TakeCamera(BesideFile(node.file, file), name, has_mount, config);
}

Result<TagMap> ReadMapSection(const YamlValue& node, const Limits& limits) {
  YamlSection section(node);
  TagMapFile file;
  section("file", file.path);
  if (file.path.empty()) {
    Result<TagMap> map = ReadTagMap(node);
    const auto problem = map ? CheckTagMap(*map) : std::nullopt;
    return problem ? Result<TagMap>(node.Refuse("a possible map, got " + *problem)) : map;
  }
  section("tag_size_m", file.tag_size_m);
  section("family", file.family);
  if (Status status = section.Finish(); !status) return status.error();
  file.path = BesideFile(node.file, file.path);
  return ReadTagMapFile(file, limits);
}

Status ReadExtrinsic(const YamlValue& node, Pose* cam_from_body) {
  YamlSection section(node);
  const auto rotation = ReadRotation(&section);
  const auto translation = ReadVector3(section.Require("translation_m"), &section);
  if (!rotation) section.Keep(node.Refuse("rotation or quaternion_xyzw, got neither"));
  if (rotation && translation) *cam_from_body = MakePose(*rotation, *translation);
  return section.Finish();
}

Status ReadIds(const YamlValue& node, std::vector<int>* ids) {
  if (node.kind != YamlValue::Kind::kList) return node.Refuse("a list of tag ids");
  for (const YamlValue& item : node.items) {
    int id = 0;
    if (const Status status = ReadInteger(item, &id); !status) return status;
    if (id < 0) return item.Refuse("a tag id, >= 0");
    ids->push_back(id);
  }
  return Ok();
}

// Takes the movable tags out of the map.
Status PassOverMovable(const std::string& file, Config* config) {
  std::vector<int>& ids = config->movable_tags;
  if (ids.empty()) return Ok();
  std::sort(ids.begin(), ids.end());
  ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
  std::vector<Tag> left = config->set_up.map.tags();
  left.erase(std::remove_if(left.begin(), left.end(),
                            [&](const Tag& tag) {
                              return std::binary_search(ids.begin(), ids.end(), tag.id);
                            }),
             left.end());
  if (left.empty()) {
    return Error{(file.empty() ? "" : file + ": ") +
                 "movable_tags: expected a tag of the map that stays, got none"};
  }
  config->set_up.map = TagMap(config->set_up.map.family(), std::move(left));
  return Ok();
}

template <typename Options>
void ReadOptions(const char* name, YamlSection* sections, Options* options) {
  const YamlValue* node = sections->Find(name);
  if (node == nullptr) return;
  YamlSection section(*node);
  Options::VisitFields(*options, section);
  section.KeepProblem(options->Problem());
  sections->Keep(section.Finish());
}

}  // namespace

Config DefaultConfig() {
  Config config;
  config.set_up.rig.front().cam_from_body = CourseCamFromBody();
  config.set_up.map = MakeTagMap(TagGrid());
  config.origins = {"the course's", "the course's", "the course's mat", true, {}};
  return config;
}

Result<Config> LoadConfig(const std::string& path) {
  return LoadConfig(ConfigFiles{path, "", "", {}, {}, {}});
}

Result<Config> LoadConfig(const ConfigFiles& files) {
  YamlValue nothing;
  nothing.kind = YamlValue::Kind::kMapping;
  const Result<YamlValue> root =
      files.config.empty() ? nothing : ReadYaml(files.config, files.limits);
  if (!root) return root.error();
  Config config = DefaultConfig();
  config.limits = files.limits;
  YamlSection sections(*root);
  const YamlValue* camera = sections.Find("camera");
  const YamlValue* mount = sections.Find("cam_from_body");
  if (camera != nullptr && files.camera_file.empty()) {
    sections.Keep(ReadCamera(*camera, mount != nullptr, &config));
  }
  if (!files.camera_file.empty()) {
    sections.Keep(TakeCamera(files.camera_file, files.camera_name, mount != nullptr, &config));
  }
  if (mount != nullptr) {
    sections.Keep(ReadExtrinsic(*mount, &config.set_up.rig.front().cam_from_body));
    config.origins.mount = mount->file;
  }
  const YamlValue* map_node = sections.Find("tag_map");
  if (map_node != nullptr || !files.map.path.empty()) {
    config.origins.map = files.map.path.empty() ? map_node->file : files.map.path;
    config.origins.map_is_assumed = false;
    Result<TagMap> map = files.map.path.empty() ? ReadMapSection(*map_node, files.limits)
                                                : ReadTagMapFile(files.map, files.limits);
    if (map) {
      config.set_up.map = std::move(*map);
    } else {
      sections.Keep(map.error());
    }
  }
  ReadOptions("detector", &sections, &config.front_end.detector);
  ReadOptions("klt", &sections, &config.front_end.klt);
  ReadOptions("closed_form", &sections, &config.front_end.closed_form);
  ReadOptions("estimator", &sections, &config.estimator);
  ReadOptions("calibration", &sections, &config.calibration);
  config.movable_tags = files.movable_tags;
  if (const YamlValue* movable = sections.Find("movable_tags"); movable != nullptr) {
    sections.Keep(ReadIds(*movable, &config.movable_tags));
  }
  if (Status status = sections.Finish(); !status) return status.error();
  if (Status status = PassOverMovable(files.config, &config); !status) return status.error();
  return config;
}

}  // namespace tagtwist
