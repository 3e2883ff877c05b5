#include "frontend/io/setup/kalibr_camera.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "frontend/base/printable.h"
#include "frontend/io/setup/camera_section.h"

namespace tagtwist::internal {

Result<Pose> ReadRigidMatrix(const YamlValue& node) {
  std::vector<double> n;
  if (Status status = ReadMatrix(node, &n); !status) return status.error();
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Zero();
  if (n.size() == 16) rotation << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  const double off = (rotation.transpose() * rotation - Eigen::Matrix3d::Identity()).norm();
  if (!(off < 1e-3) || !(rotation.determinant() > 0)) {
    return node.Refuse("a rigid 4 x 4 matrix, got another");
  }
  return MakePose(Eigen::Quaterniond(rotation).normalized(), {n[3], n[7], n[11]});
}

namespace {

void ReadTransform(const YamlValue& node, YamlSection* section, std::optional<Pose>* out) {
  const auto pose = ReadRigidMatrix(node);
  if (pose) *out = *pose;
  if (!pose) section->Keep(pose.error());
}

// The mount under one of its names, and a note on every other transform or offset.
void ReadMount(const YamlValue& node, YamlSection* section, CameraFile* out) {
  for (const auto& [key, value] : node.members) {
    const bool forward = key == "T_cam_imu";
    const bool inverse = key == "T_imu_cam" || key == "T_BS";
    if ((forward || inverse) && out->mount_key.empty()) {
      ReadTransform(value, section, &out->cam_from_body);
      if (inverse && out->cam_from_body) out->cam_from_body = Inverse(*out->cam_from_body);
      out->mount_key = key;
    } else if (key == "T_cn_cnm1") {
      ReadTransform(value, section, &out->cam_from_previous);
    } else if (key == "timeshift_cam_imu") {
      (*section)("timeshift_cam_imu", out->imu_time_shift_s);
    } else if (key.rfind("T_", 0) == 0 || key.find("timeshift") != std::string::npos) {
      out->notes.push_back(value.file + ":" + std::to_string(value.line) + ": " + key +
                           " is not used");
    }
  }
}

// Numbers that stand before fu, fv, pu, pv in the intrinsics of a camera_model.
struct KalibrModel {
  const char* name;
  LensModel lens;  // of a pinhole: what distortion_model says
  size_t before;
  bool has_distortion;
};
constexpr KalibrModel kModels[] = {{"pinhole", LensModel::kRadialTangential, 0, true},
                                   {"omni", LensModel::kOmni, 1, true},
                                   {"ds", LensModel::kDoubleSphere, 2, false},
                                   {"eucm", LensModel::kExtendedUnified, 2, false}};

KalibrModel ReadModel(YamlSection* section) {
  std::string name;
  section->Require("camera_model", &name);
  for (const KalibrModel& model : kModels) {
    if (name == model.name) return model;
  }
  if (!name.empty()) {
    section->Keep(section->Find("camera_model")->Refuse("one of pinhole, omni, ds, eucm"));
  }
  return kModels[0];
}

// What distortion_model says; a pinhole may have any, omni radtan or none, the others none.
NamedLens ReadDistortionModel(const KalibrModel& model, YamlSection* section) {
  const YamlValue* node = section->Require(std::string("distortion_model"));
  if (node == nullptr) return {};
  const auto named = ReadLensName(*node);
  section->Keep(named ? Ok() : Status(named.error()));
  if (!named) return {};
  const bool pinhole = model.before == 0;
  const bool radtan = named->has_coefficients && named->model == LensModel::kRadialTangential;
  const bool fits = pinhole || !named->has_coefficients || (model.has_distortion && radtan);
  if (!fits) {
    section->Keep(node->Refuse(model.has_distortion
                                   ? "radtan or none (the model is omni)"
                                   : std::string("none (the model is ") + model.name + ")"));
  }
  return *named;
}

// The coefficients of the lens as a whole: the intrinsics' first numbers, and the distortion's.
void ReadLens(const KalibrModel& model, const YamlValue& place,
              const std::vector<double>& intrinsics, YamlSection* section, Camera* camera) {
  const NamedLens distortion = ReadDistortionModel(model, section);
  std::vector<double> k;
  const YamlValue* list = nullptr;
  if (distortion.has_coefficients) {
    const bool euroc = section->Find("distortion_coefficients") != nullptr;
    list = section->Require(std::string(euroc ? "distortion_coefficients" : "distortion_coeffs"));
    if (list != nullptr) section->Keep(ReadNumbers(*list, 0, &k));
  }
  if (model.before == 0) {
    if (list != nullptr) section->Keep(SetLens(*list, distortion, k, camera));
    return;
  }
  k.resize(model.has_distortion ? std::max<size_t>(k.size(), 4) : 0, 0.0);
  k.insert(k.begin(), intrinsics.begin(),
           intrinsics.begin() + static_cast<std::ptrdiff_t>(model.before));
  section->Keep(SetLens(list != nullptr ? *list : place, {model.lens, true}, k, camera));
}

// Which of the names is asked for.
Result<size_t> Choose(const std::string& file, const std::vector<std::string>& names,
                      const std::string& name) {
  std::string known;
  for (size_t i = 0; i < names.size(); ++i) {
    if (names[i] == name || (name.empty() && names.size() == 1)) return i;
    known += (known.empty() ? "" : ", ") + Printable(names[i]);
  }
  return Error{file + ": camera: expected one of " + known + ", got " +
               (name.empty() ? "none (all: as a rig)" : name)};
}

// What ties a camera to others says nothing where it is taken alone.
Result<CameraFile> Alone(Result<CameraFile> read, const YamlValue& node) {
  if (!read) return read;
  for (const char* key : {"T_cn_cnm1", "timeshift_cam_imu"}) {
    const YamlValue* value = Member(node, key);
    if (value == nullptr) continue;
    read->notes.push_back(value->file + ":" + std::to_string(value->line) + ": " + key +
                          " is not used");
  }
  return read;
}

}  // namespace

std::vector<const YamlValue*> KalibrCameras(const YamlValue& root) {
  std::vector<const YamlValue*> out;
  for (const auto& [key, value] : root.members) {
    const bool is_camera = key.size() > 3 && key.compare(0, 3, "cam") == 0 &&
                           key.find_first_not_of("0123456789", 3) == std::string::npos;
    if (is_camera) out.push_back(&value);
  }
  return out;
}

Result<CameraFile> ReadKalibrCamera(const YamlValue& node) {
  YamlSection section(node);
  CameraFile out;
  const KalibrModel model = ReadModel(&section);
  std::vector<double> intrinsics, resolution;
  const auto read = [&](const char* name, size_t size, std::vector<double>* numbers) {
    const YamlValue* list = section.Require(std::string(name));
    if (list != nullptr) section.Keep(ReadNumbers(*list, size, numbers));
    numbers->resize(std::max<size_t>(size, numbers->size()), 1.0);
    return list;
  };
  const YamlValue* list = read("intrinsics", model.before + 4, &intrinsics);
  ReadLens(model, list != nullptr ? *list : node, intrinsics, &section, &out.camera);
  if (const YamlValue* size = read("resolution", 2, &resolution)) {
    for (const double side : resolution) {
      if (side != std::floor(side)) section.Keep(size->Refuse("whole numbers"));
    }
  }
  Camera& camera = out.camera;
  camera.fx = intrinsics[model.before];
  camera.fy = intrinsics[model.before + 1];
  camera.cx = intrinsics[model.before + 2];
  camera.cy = intrinsics[model.before + 3];
  camera.width = static_cast<int>(std::min(resolution[0], 1e6));
  camera.height = static_cast<int>(std::min(resolution[1], 1e6));
  ReadMount(node, &section, &out);
  section.KeepProblem(camera.Problem());
  if (Status status = section.FirstFault(); !status) return status.error();
  return out;
}

std::optional<Result<CameraFile>> ReadOneOfSeveral(const YamlValue& root, const std::string& name) {
  const std::vector<const YamlValue*> chain = KalibrCameras(root);
  std::vector<std::string> names;
  for (const YamlValue* camera : chain) names.push_back(camera->key);
  const size_t basalt = chain.empty() ? CountBasaltCameras(root) : 0;
  for (size_t i = 0; i < basalt; ++i) names.push_back("cam" + std::to_string(i));
  if (names.empty()) return std::nullopt;
  const auto chosen = Choose(root.file, names, name);
  if (!chosen) return Result<CameraFile>(chosen.error());
  if (chain.empty()) return ReadBasaltCamera(root, *chosen);
  return Alone(ReadKalibrCamera(*chain[*chosen]), *chain[*chosen]);
}

}  // namespace tagtwist::internal
