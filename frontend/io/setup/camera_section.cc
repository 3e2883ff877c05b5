#include "frontend/io/setup/camera_section.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <string>
#include <utility>
#include <vector>

#include "frontend/base/format_text.h"
#include "frontend/base/number_text.h"
#include "frontend/base/option_check.h"
#include "frontend/io/setup/tag_map_text.h"
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

constexpr Eigen::Index kFirstCoefficient = 4, kMountEntries = 6;

// Standard deviations, >= 0, from `first` on: a list of `size` numbers, or of fewer where the rest
// may be left out, which is 0.
bool ReadSigmas(const char* key, Eigen::Index size, bool all, YamlSection* section,
                Eigen::Index first, Eigen::VectorXd* sigmas) {
  constexpr double kMost = 1e6;
  const YamlValue* node = section->Find(key);
  if (node == nullptr) return false;
  std::vector<double> numbers;
  section->Keep(ReadNumbers(*node, all ? static_cast<size_t>(size) : 0, &numbers));
  if (static_cast<Eigen::Index>(numbers.size()) > size) {
    section->Keep(node->Refuse("at most " + std::to_string(size) + " numbers, got " +
                               std::to_string(numbers.size())));
    return false;
  }
  for (size_t i = 0; i < numbers.size(); ++i) {
    section->KeepProblem(CheckRange(key, numbers[i], 0.0, kMost));
    (*sigmas)(first + static_cast<Eigen::Index>(i)) = numbers[i];
  }
  return true;
}

bool ReadSigma(const char* key, YamlSection* section, double* sigma) {
  if (section->Find(key) == nullptr) return false;
  (*section)(key, *sigma);
  section->KeepProblem(CheckRange(key, *sigma, 0.0, 1.0));
  return true;
}

// Rows of a matrix of correlations below its diagonal, the first of them that of entry `first`.
void ReadCorrelations(YamlSection* section, Eigen::Index first, Eigen::MatrixXd* correlations) {
  const YamlValue* node = section->Find("correlations");
  if (node == nullptr) return;
  const auto rows = static_cast<size_t>(correlations->rows() - first);
  if (node->kind != YamlValue::Kind::kList || node->items.size() != rows) {
    section->Keep(node->Refuse("a list of " + std::to_string(rows) + " rows"));
    return;
  }
  for (size_t i = 0; i < rows; ++i) {
    std::vector<double> numbers;
    const Eigen::Index row = first + static_cast<Eigen::Index>(i);
    const Status read = ReadNumbers(node->items[i], static_cast<size_t>(row), &numbers);
    if (!read) {
      section->Keep(read);
      return;
    }
    for (Eigen::Index j = 0; j < row; ++j) {
      (*correlations)(row, j) = (*correlations)(j, row) = numbers[static_cast<size_t>(j)];
    }
  }
}

// Numbers of a file are rounded: a matrix may be as far below zero as that makes it.
void KeepImpossible(const Eigen::MatrixXd& correlations, YamlSection* section) {
  constexpr double kRounding = 1e-6;
  const YamlValue* node = section->Find("correlations");
  if (node == nullptr || !section->FirstFault()) return;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(correlations, Eigen::EigenvaluesOnly);
  if (own.info() == Eigen::Success && own.eigenvalues().minCoeff() > -kRounding) return;
  section->Keep(node->Refuse("correlations that can be, got a matrix with a negative eigenvalue"));
}

Eigen::VectorXd SigmasOf(const Eigen::MatrixXd& covariance) {
  return covariance.diagonal().cwiseMax(0).cwiseSqrt();
}

// Ones on the diagonal; 0 beside entries without an error.
Eigen::MatrixXd CorrelationsOf(const Eigen::MatrixXd& covariance) {
  const Eigen::VectorXd sigmas = SigmasOf(covariance);
  const Eigen::VectorXd scale = (sigmas.array() > 0).select(sigmas.cwiseInverse(), 0.0);
  Eigen::MatrixXd out = scale.asDiagonal() * covariance * scale.asDiagonal();
  out.diagonal().setOnes();
  return out;
}

// A key with a number or a list; nothing where all are 0.
std::string SigmaLine(const std::string& key, const Eigen::VectorXd& sigmas) {
  return sigmas.isZero(0) ? "" : key + ": " + FormatNumberList(sigmas) + "\n";
}

// Rows `first` to before `end` below the diagonal; nothing where all are 0.
std::string CorrelationLines(const Eigen::MatrixXd& covariance, Eigen::Index first,
                             Eigen::Index end, const std::string& indent) {
  const Eigen::MatrixXd correlations = CorrelationsOf(covariance);
  std::string out = indent + "correlations:\n";
  bool any = false;
  for (Eigen::Index row = first; row < end; ++row) {
    out += indent + "  - [";
    for (Eigen::Index j = 0; j < row; ++j) {
      out += (j > 0 ? ", " : "") + Format("%.10g", correlations(row, j));
      any = any || correlations(row, j) != 0;
    }
    out += "]\n";
  }
  return any ? out : "";
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

void ReadLineTime(YamlSection* section, double* line_time_s) {
  constexpr double kMostS = 1e-3;
  (*section)("line_time_s", *line_time_s);
  section->KeepProblem(CheckRange("line_time_s", *line_time_s, -kMostS, kMostS));
}

Eigen::Index LensEntries(const Camera& camera) {
  return kFirstCoefficient + static_cast<Eigen::Index>(LensCoefficients(camera.lens).size());
}

void ReadLensSigmas(YamlSection* section, const Camera& camera, Eigen::MatrixXd* covariance) {
  const Eigen::Index n = LensEntries(camera);
  Eigen::VectorXd sigmas = Eigen::VectorXd::Zero(n);
  Eigen::MatrixXd correlations = Eigen::MatrixXd::Identity(n, n);
  bool any = ReadSigma("focal_sigma", section, &sigmas(0));
  any = ReadSigma("aspect_sigma", section, &sigmas(1)) || any;
  any = ReadSigmas("principal_point_sigma_px", 2, /*all=*/true, section, 2, &sigmas) || any;
  any = ReadSigmas("distortion_sigmas", n - kFirstCoefficient, /*all=*/false, section,
                   kFirstCoefficient, &sigmas) ||
        any;
  ReadCorrelations(section, 1, &correlations);
  KeepImpossible(correlations, section);
  if (!any) return;
  covariance->setZero(n + kMountEntries, n + kMountEntries);
  covariance->topLeftCorner(n, n) = sigmas.asDiagonal() * correlations * sigmas.asDiagonal();
}

void ReadMountSigmas(YamlSection* section, bool own_lens, RigCamera* camera) {
  const Eigen::Index n = LensEntries(camera->camera), all = n + kMountEntries;
  Eigen::VectorXd sigmas = Eigen::VectorXd::Zero(all);
  bool any = ReadSigmas("rotation_sigma_rad", 3, /*all=*/true, section, n, &sigmas);
  any = ReadSigmas("translation_sigma_m", 3, /*all=*/true, section, n + 3, &sigmas) || any;
  Eigen::MatrixXd correlations = Eigen::MatrixXd::Identity(all, all);
  if (camera->covariance.rows() == all) {
    correlations.topLeftCorner(n, n) = CorrelationsOf(camera->covariance).topLeftCorner(n, n);
    sigmas.head(n) = SigmasOf(camera->covariance).head(n);
  }
  ReadCorrelations(section, n, &correlations);
  if (!own_lens) correlations.bottomLeftCorner(kMountEntries, n).setZero();
  if (!own_lens) correlations.topRightCorner(n, kMountEntries).setZero();
  for (Eigen::Index i = 0; i < all; ++i) {
    if (sigmas(i) > 0) continue;  // beside an entry without an error a correlation says nothing
    correlations.row(i).setZero();
    correlations.col(i).setZero();
    correlations(i, i) = 1;
  }
  KeepImpossible(correlations, section);
  if (any) camera->covariance = sigmas.asDiagonal() * correlations * sigmas.asDiagonal();
}

std::string LensSigmaLines(const RigCamera& camera, const std::string& indent) {
  const Eigen::Index n = LensEntries(camera.camera);
  if (camera.covariance.rows() != n + kMountEntries) return "";
  const Eigen::VectorXd s = SigmasOf(camera.covariance);
  std::string out;
  if (s(0) > 0) out += indent + "focal_sigma: " + FormatNumber(s(0)) + "\n";
  if (s(1) > 0) out += indent + "aspect_sigma: " + FormatNumber(s(1)) + "\n";
  out += SigmaLine(indent + "principal_point_sigma_px", s.segment(2, 2));
  out +=
      SigmaLine(indent + "distortion_sigmas", s.segment(kFirstCoefficient, n - kFirstCoefficient));
  return out + CorrelationLines(camera.covariance, 1, n, indent);
}

std::string MountSigmaLines(const RigCamera& camera, const std::string& indent) {
  const Eigen::Index n = LensEntries(camera.camera), all = n + kMountEntries;
  if (camera.covariance.rows() != all) return "";
  const Eigen::VectorXd s = SigmasOf(camera.covariance);
  return SigmaLine(indent + "rotation_sigma_rad", s.segment(n, 3)) +
         SigmaLine(indent + "translation_sigma_m", s.segment(n + 3, 3)) +
         CorrelationLines(camera.covariance, n, all, indent);
}

}  // namespace tagtwist::internal
