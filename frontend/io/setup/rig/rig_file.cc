#include "frontend/io/setup/rig/rig_file.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "frontend/base/printable.h"
#include "frontend/io/setup/camera_file.h"
#include "frontend/io/setup/kalibr_camera.h"
#include "frontend/io/setup/rig/tagslam_pose.h"
#include "frontend/io/setup/yaml_reader.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;

bool Exists(const fs::path& path) {
  std::error_code unknown;
  return fs::exists(path, unknown);
}

// cam0/sensor.yaml, cam1/sensor.yaml, ... of a folder.
Result<std::vector<CameraOfRig>> ReadAslFolder(const std::string& folder, const Limits& limits) {
  std::vector<CameraOfRig> out;
  for (const fs::path& root : {fs::path(folder), fs::path(folder) / "mav0"}) {
    for (size_t i = 0; out.size() == i; ++i) {
      const std::string name = "cam" + std::to_string(i);
      const fs::path path = root / name / "sensor.yaml";
      if (!Exists(path)) break;
      auto file = ReadCameraFile(path.string(), "", limits);
      if (!file) return file.error();
      out.push_back({name, std::move(*file), "", 0});
    }
    if (!out.empty()) return out;
  }
  return Error{folder + ": expected cam0/sensor.yaml, cam1/sensor.yaml, ... (EuRoC), got none"};
}

// A member that may be absent, of a file that has others, too.
template <typename T>
T Optional(const YamlValue& node, const char* name, Status* fault) {
  YamlSection section(node);
  T value{};
  section(name, value);
  if (*fault) *fault = section.FirstFault();
  return value;
}

Result<std::vector<CameraOfRig>> ReadChain(const YamlValue& root) {
  std::vector<CameraOfRig> out;
  for (const YamlValue* node : KalibrCameras(root)) {
    auto file = ReadKalibrCamera(*node);
    if (!file) return file.error();
    Status fault = Ok();
    out.push_back(
        {node->key, std::move(*file), Optional<std::string>(*node, "rostopic", &fault), 0});
    if (!fault) return fault.error();
  }
  const size_t basalt = out.empty() ? CountBasaltCameras(root) : 0;
  for (size_t i = 0; i < basalt; ++i) {
    auto file = ReadBasaltCamera(root, i);
    if (!file) return file.error();
    out.push_back({"cam" + std::to_string(i), std::move(*file), "", 0});
  }
  if (!out.empty()) return out;
  return Error{root.file +
               ": expected several cameras, cam0, cam1, ... (Kalibr camchain, TagSLAM, Basalt), "
               "got one: leave its name out"};
}

// TagSLAM's cameras are each of a body, by a pose that another file has: what it gave out last.
Status TakeTagSlamPoses(const YamlValue& root, const std::vector<std::string>& names,
                        const Limits& limits, std::vector<CameraOfRig>* cameras) {
  auto nodes = KalibrCameras(root);
  const auto is_left_out = [&](const YamlValue* node) {
    return !names.empty() && std::find(names.begin(), names.end(), node->key) == names.end();
  };
  nodes.erase(std::remove_if(nodes.begin(), nodes.end(), is_left_out), nodes.end());
  if (nodes.empty()) return Ok();
  Status fault = Ok();
  const auto body = Optional<std::string>(*nodes.front(), "rig_body", &fault);
  for (const YamlValue* node : nodes) {
    if (Optional<std::string>(*node, "rig_body", &fault) != body) {
      return node->Refuse("a camera of the same body as the others, " + body + ": name those");
    }
    if (Optional<bool>(*node, "is_static", &fault)) {
      return node->Refuse(
          "a camera that moves with its body, got is_static: write those that stand into the "
          "configuration's cameras, with mounted_on: world");
    }
  }
  const fs::path path = fs::path(root.file).parent_path() / "camera_poses.yaml";
  if (!fault || body.empty() || !Exists(path)) return fault;
  const auto poses = ReadYaml(path.string(), limits);
  if (!poses) return poses.error();
  YamlSection section(*poses);
  for (CameraOfRig& camera : *cameras) {
    const YamlValue* of_camera = section.Find(camera.name);
    if (of_camera == nullptr || camera.file.cam_from_body) continue;
    const YamlValue* pose = Member(*of_camera, "pose");
    camera.file.cam_from_body =
        Inverse(ReadTagSlamPose(pose != nullptr ? pose : of_camera, &section));
    camera.file.mount_key = path.filename().string();
  }
  return section.FirstFault();
}

// Where no camera knows the IMU the first one is the body; each other one goes by its own mount, or
// by that of the camera before it.
void PlaceAlongChain(std::vector<CameraOfRig>* cameras) {
  const bool any = std::any_of(cameras->begin(), cameras->end(), [](const CameraOfRig& camera) {
    return camera.file.cam_from_body.has_value();
  });
  const CameraFile* before = nullptr;
  for (CameraOfRig& camera : *cameras) {
    CameraFile& file = camera.file;
    const bool is_first = &camera == &cameras->front();
    if (!file.cam_from_body && before != nullptr && file.cam_from_previous) {
      file.cam_from_body = *file.cam_from_previous * *before->cam_from_body;
      file.mount_key = "T_cn_cnm1";
    } else if (!file.cam_from_body && is_first && !any) {
      file.cam_from_body = Pose();
      file.mount_key = "none";
    }
    before = file.cam_from_body ? &file : nullptr;
  }
}

Status CheckPlaces(const std::string& path, const std::vector<CameraOfRig>& cameras) {
  for (const CameraOfRig& camera : cameras) {
    if (camera.file.cam_from_body) continue;
    return Error{path + ": " + camera.name +
                 ": expected T_cn_cnm1 or T_cam_imu, or camera_poses.yaml beside it (TagSLAM), "
                 "got no place on the rig"};
  }
  return Ok();
}

constexpr double kMostOffsetS = 2e9;  // clocks that begin at zero beside those of the epoch

// The clocks count from the first camera's, whose stamps stay as they are.
Status TakeClocks(const std::string& path, std::vector<CameraOfRig>* cameras) {
  const auto first_s = cameras->front().file.imu_time_shift_s;
  for (CameraOfRig& camera : *cameras) {
    const auto own_s = camera.file.imu_time_shift_s;
    if (own_s.has_value() != first_s.has_value()) {
      return Error{path + ": " + camera.name +
                   ": expected timeshift_cam_imu of all cameras or of none"};
    }
    if (own_s) camera.clock_offset_s = *own_s - *first_s;
    if (!(std::abs(camera.clock_offset_s) <= kMostOffsetS)) {
      return Error{path + ": " + camera.name + ": timeshift_cam_imu: expected at most 2e9 s"};
    }
  }
  return Ok();
}

Result<std::vector<CameraOfRig>> Chosen(const std::string& path,
                                        const std::vector<std::string>& names,
                                        std::vector<CameraOfRig> all) {
  if (names.empty()) return all;
  std::vector<CameraOfRig> out;
  for (const std::string& name : names) {
    const auto is_it = [&](const CameraOfRig& camera) { return camera.name == name; };
    const auto found = std::find_if(all.begin(), all.end(), is_it);
    if (found == all.end()) {
      std::string known;
      for (const CameraOfRig& one : all) known += (known.empty() ? "" : ", ") + Printable(one.name);
      return Error{path + ": camera: expected some of " + known + ", got " + name};
    }
    if (std::any_of(out.begin(), out.end(), is_it)) {
      return Error{path + ": camera: expected each once, got " + name + " twice"};
    }
    out.push_back(*found);
  }
  return out;
}

Result<std::vector<CameraOfRig>> ReadAll(const std::string& path,
                                         const std::vector<std::string>& names,
                                         const Limits& limits) {
  std::error_code unknown;
  if (fs::is_directory(path, unknown)) return ReadAslFolder(path, limits);
  const auto root = ReadYaml(path, limits);
  if (!root) return root.error();
  auto cameras = ReadChain(*root);
  if (!cameras) return cameras;
  if (const Status taken = TakeTagSlamPoses(*root, names, limits, &*cameras); !taken) {
    return taken.error();
  }
  return cameras;
}

}  // namespace

Result<std::vector<CameraOfRig>> ReadRigFile(const std::string& path,
                                             const std::vector<std::string>& names,
                                             const Limits& limits) {
  auto all = ReadAll(path, names, limits);
  if (!all) return all;
  PlaceAlongChain(&*all);
  auto chosen = Chosen(path, names, std::move(*all));
  if (!chosen) return chosen;
  if (const Status placed = CheckPlaces(path, *chosen); !placed) return placed.error();
  if (const Status taken = TakeClocks(path, &*chosen); !taken) return taken.error();
  return chosen;
}

}  // namespace tagtwist::internal
