#include "frontend/io/setup/camera_section.h"

#include <algorithm>
#include <array>
#include <string>
#include <utility>

#include "frontend/base/option_check.h"
#include "frontend/types/lens/lens.h"

namespace tagtwist::internal {
namespace {

constexpr LensModel kRadTan = LensModel::kRadialTangential;
const std::array<std::pair<const char*, NamedLens>, 14> kLenses = {{
    {"radtan", {kRadTan, true}},
    {"radial-tangential", {kRadTan, true}},
    {"plumb_bob", {kRadTan, true}},
    {"rational_polynomial", {kRadTan, true}},
    {"equidistant", {LensModel::kEquidistant, true}},
    {"equi", {LensModel::kEquidistant, true}},
    {"fisheye", {LensModel::kEquidistant, true}},
    {"ds", {LensModel::kDoubleSphere, true}},
    {"double_sphere", {LensModel::kDoubleSphere, true}},
    {"eucm", {LensModel::kExtendedUnified, true}},
    {"omni", {LensModel::kOmni, true}},
    {"mei", {LensModel::kOmni, true}},
    {"fov", {LensModel::kFieldOfView, true}},
    {"none", {kRadTan, false}},
}};

// How many coefficients a model may have, and how one says so.
struct Sizes {
  std::vector<size_t> allowed;
  std::string text;
};

Sizes SizesOf(const NamedLens& lens, size_t given) {
  if (!lens.has_coefficients) return {{0}, "no coefficients (the model is none)"};
  if (lens.model == kRadTan) {
    return {{4, 5, 8},
            std::string("a list of 4, 5 or 8 numbers") +
                (given > 8 ? " (calibrate without thin prism and tilt)" : "")};
  }
  std::string text;
  const auto& coefficients = LensCoefficients(lens.model);
  for (const LensCoefficient& coefficient : coefficients) {
    text += (text.empty() ? "" : ", ") + std::string(coefficient.name);
  }
  const size_t most = coefficients.size();
  return {{most}, "a list of " + std::to_string(most) + " numbers (" + text + ")"};
}

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
  const bool polynomial = lens.model == kRadTan || lens.model == LensModel::kEquidistant;
  const Sizes sizes = SizesOf(lens, coefficients.size());
  const size_t most = sizes.allowed.back();
  while (coefficients.size() > most && coefficients.back() == 0) coefficients.pop_back();
  if (coefficients.empty() && polynomial) coefficients.resize(sizes.allowed.front(), 0.0);
  const size_t size = coefficients.size();
  if (std::find(sizes.allowed.begin(), sizes.allowed.end(), size) == sizes.allowed.end()) {
    return node.Refuse(sizes.text + ", got " + std::to_string(size));
  }
  camera->lens = lens.model;
  const auto& members = LensCoefficients(lens.model);
  for (size_t i = 0; i < size; ++i) camera->*members[i].value = coefficients[i];
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

void ReadFocalSigma(YamlSection* section, std::optional<double>* focal_sigma) {
  (*section)("focal_sigma", *focal_sigma);
  if (*focal_sigma) section->KeepProblem(CheckRange("focal_sigma", **focal_sigma, 0.0, 1.0));
}

void ReadLineTime(YamlSection* section, double* line_time_s) {
  constexpr double kMostS = 1e-3;
  (*section)("line_time_s", *line_time_s);
  section->KeepProblem(CheckRange("line_time_s", *line_time_s, -kMostS, kMostS));
}

}  // namespace tagtwist::internal
