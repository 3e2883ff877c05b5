#include "frontend/types/lens/lens.h"

#include <array>
#include <cmath>

#include "frontend/base/number_text.h"
#include "frontend/types/lens/lens_models.h"

namespace tagtwist::internal {
namespace {

struct Lens {
  const char* name;
  std::vector<LensCoefficient> coefficients;
};

const Lens& LensOf(LensModel model) {
  using C = Camera;
  static const std::array<Lens, 6> lenses = {{
      {"radtan",
       {{"k1", &C::k1},
        {"k2", &C::k2},
        {"p1", &C::p1},
        {"p2", &C::p2},
        {"k3", &C::k3},
        {"k4", &C::k4},
        {"k5", &C::k5},
        {"k6", &C::k6}}},
      {"equidistant", {{"k1", &C::k1}, {"k2", &C::k2}, {"k3", &C::k3}, {"k4", &C::k4}}},
      {"ds", {{"xi", &C::xi}, {"alpha", &C::alpha}}},
      {"eucm", {{"alpha", &C::alpha}, {"beta", &C::beta}}},
      {"omni", {{"xi", &C::xi}, {"k1", &C::k1}, {"k2", &C::k2}, {"p1", &C::p1}, {"p2", &C::p2}}},
      {"fov", {{"w", &C::w}}},
  }};
  return lenses[static_cast<size_t>(model)];
}

LensFunctions FunctionsOf(LensModel model) {
  switch (model) {
    case LensModel::kEquidistant:
      return EquidistantLens();
    case LensModel::kDoubleSphere:
      return DoubleSphereLens();
    case LensModel::kExtendedUnified:
      return ExtendedUnifiedLens();
    case LensModel::kOmni:
      return OmniLens();
    case LensModel::kFieldOfView:
      return FieldOfViewLens();
    case LensModel::kRadialTangential:
      break;
  }
  return RadialTangentialLens();
}

}  // namespace

const std::vector<LensCoefficient>& LensCoefficients(LensModel model) {
  return LensOf(model).coefficients;
}

const char* LensName(LensModel model) { return LensOf(model).name; }

bool Distort(const Camera& camera, const Eigen::Vector2d& normalised, Eigen::Vector2d* distorted,
             Eigen::Matrix2d* jacobian) {
  return FunctionsOf(camera.lens).distort(camera, normalised, distorted, jacobian);
}

std::optional<Eigen::Vector2d> Undistort(const Camera& camera, const Eigen::Vector2d& distorted) {
  return FunctionsOf(camera.lens).undistort(camera, distorted);
}

ByCoefficients DistortedByCoefficients(const Camera& camera, const Eigen::Vector2d& normalised) {
  return FunctionsOf(camera.lens).by_coefficients(camera, normalised);
}

std::optional<std::string> LensProblem(const Camera& camera) {
  for (const LensCoefficient& coefficient : LensCoefficients(camera.lens)) {
    if (!std::isfinite(camera.*coefficient.value)) return "expected finite intrinsics";
  }
  const auto expected = [](const char* name, const char* range, double value) {
    return std::string(name) + ": expected " + range + ", got " + FormatNumber(value);
  };
  const bool sphere = camera.lens == LensModel::kDoubleSphere;
  const bool unified = camera.lens == LensModel::kExtendedUnified;
  const bool has_xi = sphere || camera.lens == LensModel::kOmni;
  if (has_xi && !(camera.xi > -1)) return expected("xi", "more than -1", camera.xi);
  if ((sphere || unified) && !(camera.alpha >= 0 && camera.alpha <= 1)) {
    return expected("alpha", "0..1", camera.alpha);
  }
  if (unified && !(camera.beta > 0)) return expected("beta", "> 0", camera.beta);
  if (camera.lens == LensModel::kFieldOfView && !(camera.w > 1e-3 && camera.w < 3.14)) {
    return expected("w", "0.001..3.14 rad (the lens's field of view)", camera.w);
  }
  return std::nullopt;
}

double FocalLengthOnAxis(const Camera& camera) {
  Eigen::Vector2d distorted;
  Eigen::Matrix2d jacobian;
  const bool seen = Distort(camera, Eigen::Vector2d::Zero(), &distorted, &jacobian);
  return seen ? camera.fx * jacobian(0, 0) : camera.fx;
}

}  // namespace tagtwist::internal
