#include "estimator/config.h"

#include <cmath>

#include "estimator/tag_map_reader.h"
#include "estimator/yaml_reader.h"

namespace tagtwist {
namespace {

// Seed Eq. 1.
Pose CourseCamFromBody() {
  const double c = std::sqrt(0.5);
  Eigen::Matrix3d rotation;
  rotation << c, -c, 0, -c, -c, 0, 0, 0, -1;
  return MakePose(Eigen::Quaterniond(rotation), {-0.04, 0, -0.03});
}

// k1 k2 p1 p2 and, where there is a fifth, k3.
void ReadDistortion(const YamlValue& node, YamlSection* section, Camera* camera) {
  std::vector<double> k;
  const bool right_size = node.items.size() == 4 || node.items.size() == 5;
  section->Keep(right_size ? ReadNumbers(node, 0, &k)
                           : Status(node.Refuse("a list of 4 or 5 numbers")));
  k.resize(5, 0.0);
  camera->k1 = k[0];
  camera->k2 = k[1];
  camera->p1 = k[2];
  camera->p2 = k[3];
  camera->k3 = k[4];
}

Status ReadCamera(const YamlValue& node, Camera* camera) {
  YamlSection section(node);
  section.Require("width", &camera->width);
  section.Require("height", &camera->height);
  section.Require("fx", &camera->fx);
  section.Require("fy", &camera->fy);
  section.Require("cx", &camera->cx);
  section.Require("cy", &camera->cy);
  const YamlValue* distortion = section.Find("distortion");
  if (distortion != nullptr) ReadDistortion(*distortion, &section, camera);
  section.KeepProblem(camera->Problem());
  return section.Finish();
}

Status ReadExtrinsic(const YamlValue& node, Pose* cam_from_body) {
  YamlSection section(node);
  const auto rotation = ReadRotation(&section);
  const auto translation = ReadVector3(section.Require("translation_m"), &section);
  if (!rotation) section.Keep(node.Refuse("rotation or quaternion_xyzw, got neither"));
  if (rotation && translation) *cam_from_body = MakePose(*rotation, *translation);
  return section.Finish();
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
  config.cam_from_body = CourseCamFromBody();
  config.map = MakeTagMap(TagGrid());
  return config;
}

Result<Config> LoadConfig(const std::string& path) {
  const Result<YamlValue> root = ReadYaml(path);
  if (!root) return root.error();
  Config config = DefaultConfig();
  YamlSection sections(*root);
  if (const YamlValue* node = sections.Find("camera")) {
    sections.Keep(ReadCamera(*node, &config.camera));
  }
  if (const YamlValue* node = sections.Find("cam_from_body")) {
    sections.Keep(ReadExtrinsic(*node, &config.cam_from_body));
  }
  if (const YamlValue* node = sections.Find("tag_map")) {
    Result<TagMap> map = ReadTagMap(*node);
    if (map) {
      config.map = std::move(*map);
    } else {
      sections.Keep(map.error());
    }
  }
  ReadOptions("detector", &sections, &config.front_end.detector);
  ReadOptions("klt", &sections, &config.front_end.klt);
  ReadOptions("closed_form", &sections, &config.front_end.closed_form);
  ReadOptions("estimator", &sections, &config.estimator);
  if (Status status = sections.Finish(); !status) return status.error();
  return config;
}

}  // namespace tagtwist
