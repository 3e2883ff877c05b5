#include "frontend/io/setup/camera_section.h"

#include <algorithm>
#include <array>
#include <utility>

#include "frontend/base/option_check.h"

namespace tagtwist::internal {
namespace {

const std::array<std::pair<const char*, NamedLens>, 7> kLenses = {{
    {"radtan", {LensModel::kRadialTangential, true}},
    {"radial-tangential", {LensModel::kRadialTangential, true}},
    {"plumb_bob", {LensModel::kRadialTangential, true}},
    {"rational_polynomial", {LensModel::kRadialTangential, true}},
    {"equidistant", {LensModel::kEquidistant, true}},
    {"fisheye", {LensModel::kEquidistant, true}},
    {"none", {LensModel::kRadialTangential, false}},
}};

}  // namespace

Result<NamedLens> ReadLensName(const YamlValue& node) {
  std::string name, known;
  if (Status status = ReadValue(node, &name); !status) return status.error();
  for (const auto& [other, lens] : kLenses) {
    if (name == other) return lens;
    known += std::string(known.empty() ? "" : ", ") + other;
  }
  return node.Refuse("one of " + known);
}

Status SetLens(const YamlValue& node, const NamedLens& lens, std::vector<double> coefficients,
               Camera* camera) {
  const bool equidistant = lens.model == LensModel::kEquidistant;
  const size_t most = !lens.has_coefficients ? 0 : equidistant ? 4 : 8;
  while (coefficients.size() > most && coefficients.back() == 0) coefficients.pop_back();
  if (coefficients.empty() && most > 0) coefficients.resize(4, 0.0);  // an empty list: none
  const size_t size = coefficients.size();
  const bool known_size = size == most || (most == 8 && (size == 4 || size == 5));
  if (!known_size) {
    const char* expected = most == 0     ? "no coefficients (the model is none)"
                           : equidistant ? "a list of 4 numbers"
                           : size > 8    ? "a list of 4, 5 or 8 numbers (calibrate without thin "
                                           "prism and tilt)"
                                         : "a list of 4, 5 or 8 numbers";
    return node.Refuse(std::string(expected) + ", got " + std::to_string(size));
  }
  coefficients.resize(8, 0.0);
  const std::vector<double>& k = coefficients;
  camera->lens = lens.model;
  camera->k1 = k[0];
  camera->k2 = k[1];
  if (equidistant) {
    camera->k3 = k[2];
    camera->k4 = k[3];
    return Ok();
  }
  camera->p1 = k[2];
  camera->p2 = k[3];
  camera->k3 = k[4];
  camera->k4 = k[5];
  camera->k5 = k[6];
  camera->k6 = k[7];
  return Ok();
}

void ReadCameraKeys(YamlSection* section, Camera* camera) {
  section->Require("width", &camera->width);
  section->Require("height", &camera->height);
  section->Require("fx", &camera->fx);
  section->Require("fy", &camera->fy);
  section->Require("cx", &camera->cx);
  section->Require("cy", &camera->cy);
  NamedLens lens;
  if (const YamlValue* model = section->Find("distortion_model")) {
    const auto named = ReadLensName(*model);
    section->Keep(named ? Ok() : Status(named.error()));
    if (named) lens = *named;
    if (lens.has_coefficients) section->Require(std::string("distortion"));
  }
  if (const YamlValue* node = section->Find("distortion")) {
    std::vector<double> k;
    const Status read = ReadNumbers(*node, 0, &k);
    section->Keep(read ? SetLens(*node, lens, k, camera) : read);
  }
  section->KeepProblem(camera->Problem());
}

void ReadLineTime(YamlSection* section, double* line_time_s) {
  constexpr double kMostS = 1e-3;
  (*section)("line_time_s", *line_time_s);
  section->KeepProblem(CheckRange("line_time_s", *line_time_s, -kMostS, kMostS));
}

}  // namespace tagtwist::internal
