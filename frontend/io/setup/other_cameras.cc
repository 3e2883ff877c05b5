#include "frontend/io/setup/other_cameras.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <utility>

#include "frontend/io/setup/camera_section.h"

namespace tagtwist::internal {
namespace {

// Numbers under some names, in that order; those that are absent are left out.
std::vector<double> NumbersAt(YamlSection* section, const std::vector<std::string>& names) {
  std::vector<double> out;
  for (const std::string& name : names) {
    const YamlValue* node = section->Find(name);
    double value = 0;
    if (node == nullptr) continue;
    section->Keep(ReadValue(*node, &value));
    out.push_back(value);
  }
  return out;
}

// The same of a member's numbers.
std::vector<double> MemberNumbers(YamlSection* section, const std::string& member,
                                  const std::vector<std::string>& names) {
  const YamlValue* node = section->Find(member);
  if (node == nullptr) return {};
  YamlSection numbers(*node);
  std::vector<double> out = NumbersAt(&numbers, names);
  section->Keep(numbers.FirstFault());
  return out;
}

Result<CameraFile> Finish(const YamlValue& root, const YamlSection& section, CameraFile file) {
  if (Status status = section.FirstFault(); !status) return status.error();
  if (const auto problem = file.camera.Problem()) return Error{root.file + ": " + *problem};
  return file;
}

// ORB-SLAM 2 and 3: keys with dots. `prefix`: "Camera." or "Camera1.".
Result<CameraFile> ReadOrbSlam(const YamlValue& root, const std::string& prefix) {
  YamlSection section(root);
  CameraFile out;
  Camera& c = out.camera;
  std::string type;
  section("Camera.type", type);
  section.Require((prefix + "fx").c_str(), &c.fx);
  section.Require((prefix + "fy").c_str(), &c.fy);
  section.Require((prefix + "cx").c_str(), &c.cx);
  section.Require((prefix + "cy").c_str(), &c.cy);
  section.Require("Camera.width", &c.width);
  section.Require("Camera.height", &c.height);
  const bool fisheye = type == "KannalaBrandt8";
  const NamedLens lens{fisheye ? LensModel::kEquidistant : LensModel::kRadialTangential, true};
  const std::vector<std::string> names =
      fisheye ? std::vector<std::string>{"k1", "k2", "k3", "k4"}
              : std::vector<std::string>{"k1", "k2", "p1", "p2", "k3"};
  std::vector<std::string> keys;
  for (const std::string& name : names) keys.push_back(prefix + name);
  section.Keep(SetLens(root, lens, NumbersAt(&section, keys), &c));
  return Finish(root, section, std::move(out));
}

// camodocal's, as VINS has it: PINHOLE, KANNALA_BRANDT and MEI.
Result<CameraFile> ReadVins(const YamlValue& root, const YamlValue& projection) {
  YamlSection section(root), numbers(projection);
  CameraFile out;
  Camera& c = out.camera;
  std::string type;
  section.Require("model_type", &type);
  section.Require("image_width", &c.width);
  section.Require("image_height", &c.height);
  const bool fisheye = type == "KANNALA_BRANDT", mei = type == "MEI";
  if (!type.empty() && !fisheye && !mei && type != "PINHOLE") {
    section.Keep(Member(root, "model_type")->Refuse("PINHOLE, KANNALA_BRANDT or MEI"));
  }
  const bool by_centre = fisheye || mei;
  numbers.Require(fisheye ? "mu" : mei ? "gamma1" : "fx", &c.fx);
  numbers.Require(fisheye ? "mv" : mei ? "gamma2" : "fy", &c.fy);
  numbers.Require(by_centre ? "u0" : "cx", &c.cx);
  numbers.Require(by_centre ? "v0" : "cy", &c.cy);
  std::vector<double> k;
  if (fisheye) k = NumbersAt(&numbers, {"k2", "k3", "k4", "k5"});
  if (mei) k = MemberNumbers(&section, "mirror_parameters", {"xi"});
  if (!fisheye) {
    const auto distortion =
        MemberNumbers(&section, "distortion_parameters", {"k1", "k2", "p1", "p2"});
    k.insert(k.end(), distortion.begin(), distortion.end());
  }
  const LensModel model = fisheye ? LensModel::kEquidistant
                          : mei   ? LensModel::kOmni
                                  : LensModel::kRadialTangential;
  section.Keep(SetLens(root, {model, true}, k, &c));
  section.Keep(numbers.FirstFault());
  return Finish(root, section, std::move(out));
}

Status ReadPhotonMatrix(const YamlValue& node, std::vector<double>* numbers) {
  YamlSection section(node);
  const YamlValue* data = section.Require(std::string("data"));
  return data == nullptr ? section.FirstFault() : ReadNumbers(*data, 0, numbers);
}

Result<CameraFile> ReadPhotonVision(const YamlValue& root, const YamlValue& intrinsics) {
  YamlSection section(root);
  CameraFile out;
  Camera& c = out.camera;
  std::vector<double> k, distortion;
  section.Keep(ReadPhotonMatrix(intrinsics, &k));
  if (const YamlValue* size = section.Require(std::string("resolution"))) {
    YamlSection sides(*size);
    sides.Require("width", &c.width);
    sides.Require("height", &c.height);
    section.Keep(sides.FirstFault());
  }
  if (k.size() != 9) section.Keep(intrinsics.Refuse("nine numbers, got another matrix"));
  if (k.size() == 9) {
    c.fx = k[0];
    c.cx = k[2];
    c.fy = k[4];
    c.cy = k[5];
  }
  if (const YamlValue* coefficients = section.Find("distCoeffs")) {
    section.Keep(ReadPhotonMatrix(*coefficients, &distortion));
    section.Keep(SetLens(*coefficients, {}, distortion, &c));
  }
  return Finish(root, section, std::move(out));
}

// mrcal's .cameramodel: a mapping with a lens model's name, intrinsics of fx, fy, cx, cy and
// distortion, and the size of the images. Its transform is of a reference of mrcal's own.
Result<CameraFile> ReadMrcal(const YamlValue& root, const YamlValue& model) {
  YamlSection section(root);
  CameraFile out;
  Camera& c = out.camera;
  const std::string opencv = "LENSMODEL_OPENCV", &name = model.scalar;
  const bool known = name == "LENSMODEL_PINHOLE" || name == opencv + "4" || name == opencv + "5" ||
                     name == opencv + "8" || name == opencv + "12";
  if (!known) {
    section.Keep(
        model.Refuse("LENSMODEL_PINHOLE or LENSMODEL_OPENCV4, 5, 8 or 12 "
                     "(mrcal-convert-lensmodel makes one of any)"));
  }
  std::vector<double> intrinsics(4, 1.0), sides(2, 1.0), of_reference;
  const YamlValue* list = section.Require(std::string("intrinsics"));
  if (list != nullptr) section.Keep(ReadNumbers(*list, 0, &intrinsics));
  if (const YamlValue* size = section.Require(std::string("imagersize"))) {
    section.Keep(ReadNumbers(*size, 2, &sides));
  }
  if (list != nullptr && intrinsics.size() < 4) section.Keep(list->Refuse("fx, fy, cx, cy, ..."));
  if (!section.FirstFault()) return section.FirstFault().error();
  c.fx = intrinsics[0];
  c.fy = intrinsics[1];
  c.cx = intrinsics[2];
  c.cy = intrinsics[3];
  c.width = static_cast<int>(std::clamp(sides[0], 0.0, 1e6));
  c.height = static_cast<int>(std::clamp(sides[1], 0.0, 1e6));
  section.Keep(SetLens(*list, {}, {intrinsics.begin() + 4, intrinsics.end()}, &c));
  for (const char* key : {"extrinsics", "rt_cam_ref"}) {
    const YamlValue* pose = section.Find(key);
    if (pose == nullptr || !ReadNumbers(*pose, 0, &of_reference)) continue;
    const bool zero = std::all_of(of_reference.begin(), of_reference.end(),
                                  [](double number) { return number == 0; });
    if (zero) continue;
    out.notes.push_back(pose->file + ":" + std::to_string(pose->line) + ": " + key +
                        " is not used");
  }
  return Finish(root, section, std::move(out));
}

// Basalt's camera_type and the names of its numbers, in the order of ours.
struct BasaltModel {
  const char* name;
  LensModel lens;
  std::vector<std::string> coefficients;
};
const std::vector<BasaltModel>& BasaltModels() {
  static const std::vector<BasaltModel> all = {
      {"pinhole", LensModel::kRadialTangential, {}},
      {"pinhole-radtan8",
       LensModel::kRadialTangential,
       {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}},
      {"kb4", LensModel::kEquidistant, {"k1", "k2", "k3", "k4"}},
      {"ds", LensModel::kDoubleSphere, {"xi", "alpha"}},
      {"eucm", LensModel::kExtendedUnified, {"alpha", "beta"}},
      {"ucm", LensModel::kExtendedUnified, {"alpha"}},
      {"fov", LensModel::kFieldOfView, {"w"}}};
  return all;
}

const YamlValue* BasaltPart(const YamlValue& root, const char* name) {
  const YamlValue* value = Member(root, "value0");
  const YamlValue* part = value == nullptr ? nullptr : Member(*value, name);
  return part != nullptr && part->kind == YamlValue::Kind::kList ? part : nullptr;
}

void ReadBasaltNumbers(const YamlValue& node, const std::string& type, YamlSection* section,
                       Camera* camera) {
  YamlSection numbers(node);
  numbers.Require("fx", &camera->fx);
  numbers.Require("fy", &camera->fy);
  numbers.Require("cx", &camera->cx);
  numbers.Require("cy", &camera->cy);
  std::string known;
  for (const BasaltModel& model : BasaltModels()) {
    known += (known.empty() ? "" : ", ") + std::string(model.name);
    if (type != model.name) continue;
    std::vector<double> k = NumbersAt(&numbers, model.coefficients);
    if (type == "ucm") k.push_back(1);  // the extended model with beta = 1
    numbers.Keep(SetLens(node, {model.lens, true}, k, camera));
    return section->Keep(numbers.FirstFault());
  }
  section->Keep(section->Find("camera_type")->Refuse("one of " + known));
}

// One of T_imu_cam: {px, py, pz, qx, qy, qz, qw}.
void ReadBasaltMount(const YamlValue& node, YamlSection* section, CameraFile* out) {
  YamlSection pose(node);
  const std::vector<double> n = NumbersAt(&pose, {"px", "py", "pz", "qx", "qy", "qz", "qw"});
  section->Keep(pose.FirstFault());
  const Eigen::Quaterniond rotation =
      n.size() == 7 ? Eigen::Quaterniond(n[6], n[3], n[4], n[5]) : Eigen::Quaterniond(0, 0, 0, 0);
  if (!(std::abs(rotation.norm() - 1) < 1e-2)) {
    return section->Keep(node.Refuse("px, py, pz and a unit quaternion qx, qy, qz, qw"));
  }
  out->cam_from_body = Inverse(MakePose(rotation.normalized(), {n[0], n[1], n[2]}));
  out->mount_key = "T_imu_cam";
}

}  // namespace

size_t CountBasaltCameras(const YamlValue& root) {
  const YamlValue* cameras = BasaltPart(root, "intrinsics");
  return cameras == nullptr ? 0 : cameras->items.size();
}

Result<CameraFile> ReadBasaltCamera(const YamlValue& root, size_t index) {
  const YamlValue* mounts = BasaltPart(root, "T_imu_cam");
  const YamlValue* sizes = BasaltPart(root, "resolution");
  YamlSection section(BasaltPart(root, "intrinsics")->items[index]);
  CameraFile out;
  std::string type;
  section.Require("camera_type", &type);
  const YamlValue* numbers = section.Require(std::string("intrinsics"));
  if (!type.empty() && numbers != nullptr) {
    ReadBasaltNumbers(*numbers, type, &section, &out.camera);
  }
  std::vector<double> sides;
  if (sizes == nullptr || sizes->items.size() <= index) {
    section.Keep(root.Refuse("a resolution of each camera"));
  } else {
    section.Keep(ReadNumbers(sizes->items[index], 2, &sides));
  }
  sides.resize(2, 0);
  out.camera.width = static_cast<int>(std::clamp(sides[0], 0.0, 1e6));
  out.camera.height = static_cast<int>(std::clamp(sides[1], 0.0, 1e6));
  if (mounts != nullptr && mounts->items.size() > index) {
    ReadBasaltMount(mounts->items[index], &section, &out);
  }
  return Finish(root, section, std::move(out));
}

std::optional<Result<CameraFile>> ReadOtherCamera(const YamlValue& root) {
  for (const char* prefix : {"Camera1.", "Camera."}) {
    if (Member(root, std::string(prefix) + "fx") != nullptr) return ReadOrbSlam(root, prefix);
  }
  if (const YamlValue* projection = Member(root, "projection_parameters")) {
    return ReadVins(root, *projection);
  }
  if (const YamlValue* intrinsics = Member(root, "cameraIntrinsics")) {
    return ReadPhotonVision(root, *intrinsics);
  }
  const YamlValue* lens = Member(root, "lensmodel");
  if (lens != nullptr && lens->kind == YamlValue::Kind::kScalar) return ReadMrcal(root, *lens);
  const bool stereo = Member(root, "M1") != nullptr && Member(root, "D1") != nullptr;
  if (stereo) {
    return Result<CameraFile>(Error{root.file +
                                    ": OpenCV's stereo intrinsics do not tell the images' size: "
                                    "write camera_matrix, distortion_coefficients, image_width and "
                                    "image_height of one camera"});
  }
  return std::nullopt;
}

}  // namespace tagtwist::internal
