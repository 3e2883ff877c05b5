#include "estimator/online/camera_sections.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "frontend/base/format_text.h"
#include "frontend/io/setup/camera_file.h"
#include "frontend/io/setup/camera_section.h"
#include "frontend/io/setup/rig/rig_file.h"
#include "frontend/io/setup/tag_map_reader.h"
#include "frontend/io/setup/yaml_reader.h"

namespace tagtwist::internal {

std::string LensSigmaText(const RigCamera& camera) {
  constexpr int kCentreX = 2, kMoreThanCentre = 4;
  if (camera.covariance.rows() < kMoreThanCentre) return "";
  const Eigen::VectorXd sigmas = camera.covariance.diagonal().cwiseMax(0).cwiseSqrt();
  std::string out;
  if (sigmas(0) > 0) out += Format("focal length +- %.2g %%", 100 * sigmas(0));
  const double centre_px = sigmas.segment<2>(kCentreX).maxCoeff();
  if (centre_px > 0) out += (out.empty() ? "" : ", ") + Format("centre +- %.2g px", centre_px);
  return out;
}

std::string BesideFile(const std::string& file, const std::string& name) {
  return (std::filesystem::path(file).parent_path() / name).string();
}

namespace {

std::string SigmaText(const RigCamera& camera) {
  const std::string text = LensSigmaText(camera);
  return text.empty() ? "" : " (" + text + ")";
}

}  // namespace

Status TakeCamera(const std::string& path, const std::string& name, bool has_mount,
                  const Limits& limits, RigCamera* camera, CameraOrigin* origin) {
  const Result<CameraFile> file = ReadCameraFile(path, name, limits);
  if (!file) return file.error();
  camera->camera = file->camera;
  camera->line_time_s = file->line_time_s;
  camera->covariance = file->covariance;
  origin->camera = path + (name.empty() ? "" : ", " + name) + SigmaText(*camera);
  origin->notes = file->notes;
  if (has_mount && file->cam_from_body) {
    origin->notes.push_back(path + ": its mount, " + file->mount_key +
                            ", is not used: the configuration has cam_from_body");
  }
  if (has_mount) return Ok();
  camera->cam_from_body = file->cam_from_body.value_or(Pose());
  origin->mount_is_given = file->cam_from_body.has_value();
  origin->mount =
      file->cam_from_body ? file->mount_key + " of " + path : "none given: the camera is the body";
  return Ok();
}

Status ReadCamera(const YamlValue& node, bool has_mount, const Limits& limits, RigCamera* camera,
                  CameraOrigin* origin) {
  YamlSection section(node);
  std::string file, name;
  section("file", file);
  if (file.empty()) {
    camera->camera = Camera();
    ReadCameraKeys(&section, &camera->camera);
    ReadLineTime(&section, &camera->line_time_s);
    camera->covariance.resize(0, 0);
    ReadLensSigmas(&section, camera->camera, &camera->covariance);
    origin->camera = node.file + SigmaText(*camera);
    origin->mount_is_given = has_mount;
    return section.Finish();
  }
  section("name", name);
  if (Status status = section.Finish(); !status) return status;
  return TakeCamera(BesideFile(node.file, file), name, has_mount, limits, camera, origin);
}

Status ReadExtrinsic(const YamlValue& node, bool own_lens, RigCamera* camera) {
  YamlSection section(node);
  const auto rotation = ReadRotation(&section);
  const auto translation = ReadVector3(section.Require("translation_m"), &section);
  if (!rotation) section.Keep(node.Refuse("rotation or quaternion_xyzw, got neither"));
  if (rotation && translation) camera->cam_from_body = MakePose(*rotation, *translation);
  ReadMountSigmas(&section, own_lens, camera);
  return section.Finish();
}

namespace {

Result<CameraEntry> ReadEntry(const YamlValue& node, const Limits& limits) {
  constexpr double kMostOffsetS = 1e9;  // clocks that begin at zero beside those of the epoch
  if (node.kind != YamlValue::Kind::kMapping) return node.Refuse("a camera's keys");
  YamlSection section(node);
  CameraEntry out;
  section.Require("name", &out.camera.name);
  out.recording = out.camera.name;
  section("recording", out.recording);
  section("topic", out.topic);
  section("clock_offset_s", out.camera.clock_offset_s);
  if (!(std::abs(out.camera.clock_offset_s) <= 2 * kMostOffsetS)) {
    section.Keep(section.Find("clock_offset_s")->Refuse("from -2e9 to 2e9 s"));
  }
  section("mounted_on", out.mounted_on);
  const bool on_body = out.mounted_on == MountedOn::kBody;
  const YamlValue* in_body = section.Find("cam_from_body");
  const YamlValue* in_world = section.Find("cam_from_world");
  const YamlValue* mount = on_body ? in_body : in_world;
  if (const YamlValue* other = on_body ? in_world : in_body) {
    section.Keep(other->Refuse(on_body ? "cam_from_body, or mounted_on: world beside it"
                                       : "cam_from_world, for the camera stands"));
  }
  const YamlValue* camera = section.Require(std::string("camera"));
  if (camera != nullptr) {
    section.Keep(ReadCamera(*camera, mount != nullptr, limits, &out.camera, &out.origin));
  }
  if (mount != nullptr) {
    section.Keep(ReadExtrinsic(*mount, /*own_lens=*/true, &out.camera));
    out.origin.mount = mount->file;
  }
  if (Status status = section.Finish(); !status) return status.error();
  if (out.camera.name.empty()) return section.Find("name")->Refuse("a name");
  if (!on_body && mount == nullptr) return node.Refuse("cam_from_world, where the camera stands");
  if (!out.origin.mount_is_given) {
    return node.Refuse("cam_from_body, or a calibration with a mount");
  }
  return out;
}

Result<std::vector<CameraEntry>> ReadNamedFile(const YamlValue& node, const Limits& limits) {
  YamlSection section(node);
  std::string file;
  std::vector<std::string> names;
  section.Require("file", &file);
  if (const YamlValue* list = section.Find("names")) {
    if (list->kind != YamlValue::Kind::kList || list->items.empty()) {
      section.Keep(list->Refuse("a list of names"));
    }
    for (const YamlValue& item : list->items) {
      section.Keep(ReadValue(item, &names.emplace_back()));
    }
  }
  if (Status status = section.Finish(); !status) return status.error();
  return CamerasOfFile(BesideFile(node.file, file), names, limits);
}

}  // namespace

Result<std::vector<CameraEntry>> CamerasOfFile(const std::string& path,
                                               const std::vector<std::string>& names,
                                               const Limits& limits) {
  auto cameras = ReadRigFile(path, names, limits);
  if (!cameras) return cameras.error();
  std::vector<CameraEntry> out;
  for (CameraOfRig& one : *cameras) {
    CameraEntry entry;
    entry.camera.name = entry.recording = one.name;
    entry.camera.camera = one.file.camera;
    entry.camera.line_time_s = one.file.line_time_s;
    entry.camera.cam_from_body = *one.file.cam_from_body;
    entry.camera.clock_offset_s = one.clock_offset_s;
    entry.topic = std::move(one.topic);
    entry.camera.covariance = std::move(one.file.covariance);
    entry.origin.notes = std::move(one.file.notes);
    out.push_back(std::move(entry));
  }
  return out;
}

Result<std::vector<CameraEntry>> ReadCameras(const YamlValue& node, const Limits& limits) {
  if (node.kind == YamlValue::Kind::kMapping) return ReadNamedFile(node, limits);
  if (node.kind != YamlValue::Kind::kList || node.items.empty()) {
    return node.Refuse("a list of cameras, or {file: ...} of a calibration with several");
  }
  std::vector<CameraEntry> out;
  for (const YamlValue& item : node.items) {
    auto entry = ReadEntry(item, limits);
    if (!entry) return entry.error();
    const bool twice = std::any_of(out.begin(), out.end(), [&](const CameraEntry& other) {
      return other.camera.name == entry->camera.name;
    });
    if (twice) return Member(item, "name")->Refuse("a name that no other camera has");
    if (!out.empty() && entry->mounted_on != out.front().mounted_on) {
      return item.Refuse("all cameras on the body, or all in the world");
    }
    out.push_back(std::move(*entry));
  }
  return out;
}

}  // namespace tagtwist::internal
