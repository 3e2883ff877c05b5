#include "frontend/io/setup/camera_file.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <utility>
#include <vector>

#include "frontend/base/files/input_file.h"
#include "frontend/base/number_text.h"
#include "frontend/io/recordings/camera_info.h"
#include "frontend/io/setup/camera_section.h"
#include "frontend/io/setup/kalibr_camera.h"
#include "frontend/io/setup/opencv_xml.h"
#include "frontend/io/setup/other_cameras.h"
#include "frontend/io/setup/yaml_reader.h"
#include "frontend/io/setup/yaml_tree.h"

namespace tagtwist::internal {
namespace {

// The member that goes by one of several names; the first of them is told where there is none.
const YamlValue* RequireOneOf(std::initializer_list<const char*> names, YamlSection* section) {
  for (const char* name : names) {
    if (const YamlValue* node = section->Find(name)) return node;
  }
  return section->Require(std::string(*names.begin()));
}

void ReadCameraMatrix(const YamlValue* node, YamlSection* section, Camera* camera) {
  if (node == nullptr) return;
  std::vector<double> k;
  if (Status status = ReadMatrix(*node, &k); !status) return section->Keep(status);
  const bool is_pinhole = k.size() == 9 && k[1] == 0 && k[3] == 0 && k[6] == 0 && k[7] == 0 &&
                          k[8] == 1 && k[0] > 0 && k[4] > 0;
  if (!is_pinhole) {
    const bool zero = std::all_of(k.begin(), k.end(), [](double x) { return x == 0; });
    const bool skewed = k.size() == 9 && k[1] != 0 && k[0] > 0;
    return section->Keep(node->Refuse(
        zero     ? "a calibrated camera, got a matrix of zeros: this one was never calibrated"
        : skewed ? "[fx, 0, cx, 0, fy, cy, 0, 0, 1], got a skew of " + FormatNumber(k[1]) +
                       ": calibrate without it"
                 : "[fx, 0, cx, 0, fy, cy, 0, 0, 1], got another matrix"));
  }
  camera->fx = k[0];
  camera->cx = k[2];
  camera->fy = k[4];
  camera->cy = k[5];
}

// camera_info's region of interest and binning: its other members are of the full image. A pixel of
// the binned image is the mean of its block.
Status ApplyWindow(YamlSection* section, CameraFile* out) {
  int x = 0, y = 0, width = 0, height = 0, bin_x = 0, bin_y = 0;
  if (const YamlValue* roi = section->Find("roi")) {
    YamlSection window(*roi);
    window("x_offset", x);
    window("y_offset", y);
    window("width", width);
    window("height", height);
    section->Keep(window.FirstFault());
  }
  (*section)("binning_x", bin_x);
  (*section)("binning_y", bin_y);
  if (Status status = section->FirstFault(); !status) return status;
  Camera& c = out->camera;
  bin_x = std::max(1, bin_x);
  bin_y = std::max(1, bin_y);
  const bool all = width == 0 || height == 0;
  if (all && bin_x == 1 && bin_y == 1) return Ok();
  c.width = (all ? c.width : width) / bin_x;
  c.height = (all ? c.height : height) / bin_y;
  c.cx = (c.cx - x + 0.5) / bin_x - 0.5;
  c.cy = (c.cy - y + 0.5) / bin_y - 0.5;
  c.fx /= bin_x;
  c.fy /= bin_y;
  if (const auto problem = c.Problem()) return Error{section->file() + ": " + *problem};
  out->notes.push_back(section->file() + ": its region of interest and binning are applied: " +
                       std::to_string(c.width) + " x " + std::to_string(c.height) + " px");
  return Ok();
}

// OpenCV's calibration and ROS camera_info: they share their members but for a few names.
Result<CameraFile> ReadOpenCvOrRos(const YamlValue& root) {
  YamlSection section(root);
  CameraFile out;
  const auto read_size = [&](std::initializer_list<const char*> names, int* size) {
    const YamlValue* node = RequireOneOf(names, &section);
    if (node != nullptr) section.Keep(ReadValue(*node, size));
  };
  if (const YamlValue* size = section.Find("img_size")) {
    std::vector<double> sides;
    section.Keep(ReadNumbers(*size, 2, &sides));
    if (sides.size() == 2) {
      out.camera.width = static_cast<int>(std::clamp(sides[0], 0.0, 1e6));
      out.camera.height = static_cast<int>(std::clamp(sides[1], 0.0, 1e6));
    }
  } else {
    read_size({"image_width", "image_Width", "width"}, &out.camera.width);
    read_size({"image_height", "image_Height", "height"}, &out.camera.height);
  }
  ReadCameraMatrix(
      RequireOneOf({"camera_matrix", "Camera_Matrix", "cameraMatrix", "K", "k"}, &section),
      &section, &out.camera);
  NamedLens lens;
  int fisheye = 0;
  section("fisheye_model", fisheye);
  if (fisheye != 0) lens.model = LensModel::kEquidistant;
  if (const YamlValue* node = section.Find("distortion_model")) {
    const auto named = ReadLensName(*node);
    section.Keep(named ? Ok() : Status(named.error()));
    if (named) lens = *named;
  }
  const auto distortion = {"distortion_coefficients",
                           "Distortion_Coefficients",
                           "distCoeffs",
                           "dist_coeffs",
                           "dist_coeff",
                           "D",
                           "d"};
  if (const YamlValue* node = RequireOneOf(distortion, &section)) {
    std::vector<double> k;
    const Status read = ReadMatrix(*node, &k);
    section.Keep(read ? SetLens(*node, lens, k, &out.camera) : read);
  }
  section.KeepProblem(out.camera.Problem());
  if (Status status = section.FirstFault(); !status) return status.error();
  if (Status status = ApplyWindow(&section, &out); !status) return status.error();
  return out;
}

Result<CameraFile> ReadOwn(const YamlValue& node) {
  YamlSection section(node);
  CameraFile out;
  ReadCameraKeys(&section, &out.camera);
  ReadLineTime(&section, &out.line_time_s);
  ReadLensSigmas(&section, out.camera, &out.covariance);
  if (Status status = section.Finish(); !status) return status.error();
  return out;
}

Result<CameraFile> ReadCameraOfBag(const std::string& path, const std::string& topic,
                                   const Limits& limits) {
  auto text = ReadBagCameraInfo(path, topic, limits);
  if (!text) return text.error();
  const auto root = ParseYaml(std::move(*text), path, limits);
  return root ? ReadOpenCvOrRos(*root) : root.error();
}

// mrcal's models carry what they were made from, as bytes b'...' in which any sign may stand.
void DropBytes(std::string* text) {
  if (text->find("'lensmodel'") == std::string::npos) return;
  for (size_t begin = 0; (begin = text->find("b'", begin)) != std::string::npos; ++begin) {
    const size_t end = text->find('\'', begin + 2);
    if (end == std::string::npos) return;
    text->replace(begin, end + 1 - begin, "''");
  }
}

// Read once: a pipe gives its bytes only once.
Result<YamlValue> ReadTree(const std::string& path, const Limits& limits) {
  auto text = ReadTextFile(path, limits);
  if (!text) return text.error();
  DropBytes(&*text);
  return LooksLikeXml(*text) ? ParseOpenCvXml(*text, path, limits)
                             : ParseYaml(std::move(*text), path, limits);
}

}  // namespace

Result<CameraFile> ReadCameraFile(const std::string& path, const std::string& name,
                                  const Limits& limits) {
  if (IsRosBag(path)) return ReadCameraOfBag(path, name, limits);
  const Result<YamlValue> root = ReadTree(path, limits);
  if (!root) return root.error();
  if (const auto of_several = ReadOneOfSeveral(*root, name)) return *of_several;
  if (!name.empty()) {
    return Error{path + ": camera: expected no name for a file with one camera, got " + name};
  }
  const YamlValue* section = Member(*root, "camera");
  if (section != nullptr && section->kind == YamlValue::Kind::kMapping) return ReadOwn(*section);
  if (const auto other = ReadOtherCamera(*root)) return *other;
  if (Member(*root, "fx") != nullptr) return ReadOwn(*root);
  if (Member(*root, "camera_model") != nullptr) return ReadKalibrCamera(*root);
  return ReadOpenCvOrRos(*root);
}

}  // namespace tagtwist::internal
