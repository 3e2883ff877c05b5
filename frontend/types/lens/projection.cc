#include <Eigen/LU>
#include <cmath>
#include <utility>

#include "frontend/base/number_text.h"
#include "frontend/types/camera.h"
#include "frontend/types/lens/lens.h"

namespace tagtwist {

using namespace internal;
namespace {

constexpr double kMinDepthM = 1e-3;
constexpr int kMaxImageSide = 16384;  // [px]
constexpr double kMostFocalLengthPx = 1e6;

}  // namespace

bool Camera::Project(const Eigen::Vector3d& point_in_cam, Eigen::Vector2d* pixel,
                     Eigen::Matrix<double, 2, 3>* d_pixel_d_point) const {
  if (!(point_in_cam.z() >= kMinDepthM)) return false;
  const double iz = 1.0 / point_in_cam.z();
  const Eigen::Vector2d normalised = point_in_cam.head<2>() * iz;
  Eigen::Matrix2d d_distorted = Eigen::Matrix2d::Identity();
  Eigen::Vector2d distorted = normalised;
  if (IsDistorted() && !Distort(*this, normalised, &distorted, &d_distorted)) return false;
  *pixel << fx * distorted.x() + cx, fy * distorted.y() + cy;
  if (d_pixel_d_point != nullptr) {
    Eigen::Matrix<double, 2, 3> d_normalised;
    d_normalised << iz, 0, -normalised.x() * iz, 0, iz, -normalised.y() * iz;
    *d_pixel_d_point = Eigen::Vector2d(fx, fy).asDiagonal() * d_distorted * d_normalised;
  }
  return true;
}

std::optional<Eigen::Vector2d> Camera::Unproject(const Eigen::Vector2d& pixel,
                                                 Eigen::Matrix2d* d_normalised_d_pixel) const {
  const Eigen::Vector2d distorted((pixel.x() - cx) / fx, (pixel.y() - cy) / fy);
  std::optional<Eigen::Vector2d> normalised = distorted;
  Eigen::Matrix2d jacobian = Eigen::Matrix2d::Identity();
  if (IsDistorted()) {
    normalised = Undistort(*this, distorted);
    Eigen::Vector2d again;
    if (!normalised || !Distort(*this, *normalised, &again, &jacobian)) return std::nullopt;
  }
  if (d_normalised_d_pixel != nullptr) {
    *d_normalised_d_pixel =
        jacobian.inverse() * Eigen::Vector2d(1.0 / fx, 1.0 / fy).asDiagonal().toDenseMatrix();
  }
  return normalised;
}

std::optional<std::string> Camera::Problem() const {
  for (const auto& [key, size] : {std::pair("width", width), std::pair("height", height)}) {
    if (size < 1 || size > kMaxImageSide) {
      return std::string(key) + ": expected 1.." + std::to_string(kMaxImageSide) + ", got " +
             std::to_string(size);
    }
  }
  for (const auto& [key, length] : {std::pair("fx", fx), std::pair("fy", fy)}) {
    if (!(length > 0)) return std::string(key) + ": expected > 0, got " + FormatNumber(length);
    if (length <= kMostFocalLengthPx) continue;
    return std::string(key) + ": expected at most 1e6 px, got " + FormatNumber(length);
  }
  for (const double value : {cx, cy}) {
    if (!std::isfinite(value)) return "expected finite intrinsics";
  }
  return LensProblem(*this);
}

}  // namespace tagtwist
