#include "estimator/online/config.h"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <utility>

#include "estimator/online/bodies_section.h"
#include "estimator/online/camera_sections.h"
#include "estimator/online/imu/imu_section.h"
#include "estimator/online/map_section.h"
#include "frontend/base/format_text.h"
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

// What a camera's section or file says, into the origins of the set-up.
void TellOrigin(const CameraOrigin& origin, SetUpOrigins* out) {
  out->camera = origin.camera;
  if (!origin.mount.empty()) out->mount = origin.mount;
  out->notes = origin.notes;
}

// cam0,cam1: names of several; all: of all, an empty list.
std::vector<std::string> NamesOfSeveral(const std::string& text) {
  std::vector<std::string> out;
  std::istringstream list(text == "all" ? "" : text);
  for (std::string name; std::getline(list, name, ',');) out.push_back(name);
  return out;
}

bool IsOfSeveral(const ConfigFiles& files) {
  return !files.camera_file.empty() &&
         (files.camera_name == "all" || files.camera_name.find(',') != std::string::npos);
}

// The cameras that the section `cameras` has or names, or, where there is none, --camera_file.
Result<std::vector<CameraEntry>> SeveralCameras(const YamlValue* node, const ConfigFiles& files,
                                                const Limits& limits) {
  if (node == nullptr) {
    return CamerasOfFile(files.camera_file, NamesOfSeveral(files.camera_name), limits);
  }
  if (!files.camera_file.empty()) {
    return Error{files.camera_file + ": --camera_file is of one camera, and " + node->file +
                 " has cameras of its own"};
  }
  return ReadCameras(*node, limits);
}

// `node`: the section `cameras`, or none.
Status TakeCameras(const YamlValue* node, YamlSection* sections, const ConfigFiles& files,
                   Config* config) {
  for (const char* of_one : {"camera", "cam_from_body", "cam_from_world"}) {
    if (const YamlValue* other = sections->Find(of_one)) {
      return other->Refuse("no such section beside several cameras, which have one each");
    }
  }
  auto entries = SeveralCameras(node, files, config->limits);
  if (!entries) return entries.error();
  config->set_up.rig.cameras.clear();
  SetUpOrigins& origins = config->origins;
  origins.camera = origins.mount = node != nullptr ? node->file : files.camera_file;
  for (CameraEntry& entry : *entries) {
    config->recordings.push_back({std::move(entry.recording), std::move(entry.topic)});
    config->set_up.rig.mounted_on = entry.mounted_on;
    config->set_up.rig.cameras.push_back(std::move(entry.camera));
    origins.notes.insert(origins.notes.end(), entry.origin.notes.begin(), entry.origin.notes.end());
  }
  return Ok();
}

// The tags that stand, or that the only body carries, and what other bodies carry. `node`: the
// section `tag_map`, or none.
Status TakeMap(const YamlValue* node, const ConfigFiles& files, Config* config,
               std::optional<double>* sigma_m) {
  const bool from_file = !files.map.path.empty();
  const bool stand = config->set_up.rig.mounted_on == MountedOn::kWorld;
  config->origins.map = from_file ? files.map.path : node->file;
  config->origins.map_is_assumed = false;
  const YamlValue* bodies = node == nullptr ? nullptr : Member(*node, "bodies");
  if (bodies != nullptr) {
    auto read = ReadBodies(*node, files.limits, sigma_m);
    if (!read) return read.error();
    config->bodies = std::move(*read);
    const bool has_tags = from_file || HasOwnTags(*node);
    if (stand == has_tags) {
      return bodies->Refuse(stand ? "no tags beside them: the cameras stand, and see bodies alone"
                                  : "tags that stand beside them: the cameras move");
    }
  }
  if (bodies != nullptr && stand) {
    config->set_up.map = config->bodies.front().map;
    config->body = config->bodies.front().name;
    config->bodies.erase(config->bodies.begin());
  } else {
    std::optional<double> of_map;
    Result<TagMap> map = from_file ? ReadTagMapFile(files.map, files.limits)
                                   : ReadMapSection(WithoutBodies(*node), files.limits, &of_map);
    if (!map) return map.error();
    config->set_up.map = std::move(*map);
    if (from_file) of_map = SigmaOfMapFile(files.map.path, files.limits);
    *sigma_m = std::max(*sigma_m, of_map);
    if (bodies != nullptr) {
      const Status once = CheckOnce(*bodies, config->set_up.map, config->bodies);
      if (!once) return once;
    }
  }
  if (*sigma_m) config->origins.map += Format(" (tags +- %.2g mm)", 1e3 * **sigma_m);
  return Ok();
}

// The camera of a run that has one, of the configuration or of a file.
void TakeOnlyCamera(const ConfigFiles& files, YamlSection* sections, Config* config) {
  const YamlValue* camera = sections->Find("camera");
  const YamlValue* mount = sections->Find("cam_from_body");
  const YamlValue* in_world = sections->Find("cam_from_world");
  RigCamera* mounted = &config->set_up.rig.front();
  if (in_world != nullptr) {
    if (mount != nullptr) {
      sections->Keep(
          in_world->Refuse("no such section beside cam_from_body: a camera moves or stands"));
    }
    config->set_up.rig.mounted_on = MountedOn::kWorld;
    mount = in_world;
  }
  CameraOrigin origin;
  if (camera != nullptr && files.camera_file.empty()) {
    sections->Keep(ReadCamera(*camera, mount != nullptr, config->limits, mounted, &origin));
    TellOrigin(origin, &config->origins);
  }
  if (!files.camera_file.empty()) {
    sections->Keep(TakeCamera(files.camera_file, files.camera_name, mount != nullptr,
                              config->limits, mounted, &origin));
    TellOrigin(origin, &config->origins);
  }
  if (mount == nullptr) return;
  const bool own_lens = camera != nullptr && files.camera_file.empty();
  sections->Keep(ReadExtrinsic(*mount, own_lens, mounted));
  config->origins.mount = mount->file;
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
  if (!config->body.empty()) {
    return Error{(file.empty() ? "" : file + ": ") +
                 "movable_tags: expected none beside bodies: leave these tags out of them"};
  }
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

TagMap Config::AllTags() const {
  std::vector<Tag> all = set_up.map.tags();
  for (const TaggedBody& other : bodies) {
    all.insert(all.end(), other.map.tags().begin(), other.map.tags().end());
  }
  return TagMap(set_up.map.family(), std::move(all));
}

std::vector<SetUp> Config::SetUps() const {
  std::vector<SetUp> out = {set_up};
  for (const TaggedBody& other : bodies) out.push_back({set_up.rig, other.map});
  return out;
}

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
  const YamlValue* cameras = sections.Find("cameras");
  if (cameras != nullptr || IsOfSeveral(files)) {
    sections.Keep(TakeCameras(cameras, &sections, files, &config));
  } else {
    TakeOnlyCamera(files, &sections, &config);
  }
  const YamlValue* map_node = sections.Find("tag_map");
  std::optional<double> tag_sigma_m;
  if (map_node != nullptr || !files.map.path.empty()) {
    sections.Keep(TakeMap(map_node, files, &config, &tag_sigma_m));
  }
  ReadOptions("detector", &sections, &config.front_end.detector);
  ReadOptions("klt", &sections, &config.front_end.klt);
  ReadOptions("closed_form", &sections, &config.front_end.closed_form);
  ReadOptions("estimator", &sections, &config.estimator);
  if (const YamlValue* imu = sections.Find("imu"); imu != nullptr) {
    sections.Keep(ReadImu(*imu, files.limits, &config.imu));
  }
  // What the section `estimator` says goes before what the map's own file does.
  if (!config.estimator.tag_sigma_m) config.estimator.tag_sigma_m = tag_sigma_m;
  ReadOptions("calibration", &sections, &config.calibration);
  config.movable_tags = files.movable_tags;
  if (const YamlValue* movable = sections.Find("movable_tags"); movable != nullptr) {
    sections.Keep(ReadIds(*movable, &config.movable_tags));
  }
  if (Status status = sections.Finish(); !status) return status.error();
  if (Status status = PassOverMovable(files.config, &config); !status) return status.error();
  if (!config.bodies.empty()) config.estimator.clock = ClockChoice::kStamps;  // one for all
  return config;
}

}  // namespace tagtwist
