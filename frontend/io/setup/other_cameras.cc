#include "frontend/io/setup/other_cameras.h"

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

// camodocal's, as VINS has it: PINHOLE and KANNALA_BRANDT.
Result<CameraFile> ReadVins(const YamlValue& root, const YamlValue& projection) {
  YamlSection section(root), numbers(projection);
  CameraFile out;
  Camera& c = out.camera;
  std::string type;
  section.Require("model_type", &type);
  section.Require("image_width", &c.width);
  section.Require("image_height", &c.height);
  const bool fisheye = type == "KANNALA_BRANDT";
  if (!type.empty() && !fisheye && type != "PINHOLE") {
    section.Keep(Member(root, "model_type")->Refuse("PINHOLE or KANNALA_BRANDT"));
  }
  numbers.Require(fisheye ? "mu" : "fx", &c.fx);
  numbers.Require(fisheye ? "mv" : "fy", &c.fy);
  numbers.Require(fisheye ? "u0" : "cx", &c.cx);
  numbers.Require(fisheye ? "v0" : "cy", &c.cy);
  const NamedLens lens{fisheye ? LensModel::kEquidistant : LensModel::kRadialTangential, true};
  if (fisheye) {
    section.Keep(SetLens(root, lens, NumbersAt(&numbers, {"k2", "k3", "k4", "k5"}), &c));
  } else if (const YamlValue* distortion = section.Find("distortion_parameters")) {
    YamlSection coefficients(*distortion);
    section.Keep(SetLens(root, lens, NumbersAt(&coefficients, {"k1", "k2", "p1", "p2"}), &c));
    section.Keep(coefficients.FirstFault());
  }
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

}  // namespace

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
