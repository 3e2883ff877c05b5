#pragma once
#include <Eigen/Core>
#include <optional>
#include <string>

namespace tagtwist {

/// What a lens does to normalised coordinates (x, y), r^2 = x^2 + y^2.
enum class LensModel {
  /// Brown-Conrady, OpenCV's model and order k1 k2 p1 p2 k3 k4 k5 k6:
  ///   x' = x (1 + k1 r^2 + k2 r^4 + k3 r^6) / (1 + k4 r^2 + k5 r^4 + k6 r^6)
  ///        + 2 p1 x y + p2 (r^2 + 2 x^2),  y' with p1 and p2, x and y exchanged.
  kRadialTangential,
  /// Kannala and Brandt 2006, OpenCV's and Kalibr's k1..k4, theta = atan(r):
  ///   (x', y') = (x, y) / r * theta (1 + k1 theta^2 + k2 theta^4 + k3 theta^6 + k4 theta^8).
  kEquidistant,
  /// Double sphere, Usenko, Demmel and Cremers 2018, xi and alpha, d = sqrt(r^2 + 1), z = xi d + 1:
  ///   (x', y') = (x, y) / (alpha sqrt(r^2 + z^2) + (1 - alpha) z).
  kDoubleSphere,
  /// Extended unified (EUCM), Khomutenko, Garcia and Martinet 2016, alpha and beta:
  ///   (x', y') = (x, y) / (alpha sqrt(beta r^2 + 1) + 1 - alpha).
  kExtendedUnified,
  /// Unified with distortion, Mei and Rives 2007, Kalibr's omni, xi and k1 k2 p1 p2:
  ///   (x, y) / (xi sqrt(r^2 + 1) + 1), and of that what kRadialTangential says.
  kOmni,
  /// Field of view, Devernay and Faugeras 2001, w [rad]:
  ///   (x', y') = (x, y) / r * atan(2 r tan(w / 2)) / w.
  kFieldOfView
};

/// Pinhole camera with a lens. Pixels follow OpenCV: the centre of the top-left pixel is (0, 0).
/// Defaults: the course's camera, images already rectified (design of the data set).
struct Camera {
  int width = 376, height = 240;        // [px]
  double fx = 311.0520, fy = 311.3885;  // [px]
  double cx = 201.8724, cy = 113.6210;  // [px]
  LensModel lens = LensModel::kRadialTangential;
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0, k4 = 0, k5 = 0, k6 = 0;
  double xi = 0, alpha = 0, beta = 1, w = 0;  // of the models that have them

  /// False when normalised coordinates are those of a pinhole.
  bool IsDistorted() const {
    return k1 != 0 || k2 != 0 || p1 != 0 || p2 != 0 || k3 != 0 || k4 != 0 || k5 != 0 || k6 != 0 ||
           lens != LensModel::kRadialTangential;
  }

  /// Pixel of point_in_cam [m]; false (outputs untouched) when the depth is below 1 mm, or where
  /// the lens model folds: further out there it maps back into the image.
  /// The pixel may lie outside the image. The optional Jacobian is 2x3 [px/m].
  bool Project(const Eigen::Vector3d& point_in_cam, Eigen::Vector2d* pixel,
               Eigen::Matrix<double, 2, 3>* d_pixel_d_point = nullptr) const;

  /// Normalised image coordinates (x = X/Z, y = Y/Z) seen at a pixel; nullopt where the lens has
  /// none, or further than 89 degrees off the axis. The optional Jacobian is 2x2 [1/px].
  std::optional<Eigen::Vector2d> Unproject(const Eigen::Vector2d& pixel,
                                           Eigen::Matrix2d* d_normalised_d_pixel = nullptr) const;

  /// True when the pixel lies on the image, at least margin_px from its border.
  bool Contains(const Eigen::Vector2d& pixel, double margin_px = 0) const {
    return pixel.x() >= margin_px && pixel.y() >= margin_px && pixel.x() <= width - 1 - margin_px &&
           pixel.y() <= height - 1 - margin_px;
  }

  /// The broken rule, or nullopt when the camera can be used.
  std::optional<std::string> Problem() const;
};

}  // namespace tagtwist
