#pragma once
#include <Eigen/Core>
#include <array>
#include <vector>

namespace tagtwist::internal {

/// Smooth fields over an image as values on a grid of knots, bilinear between them: what a lens
/// model leaves. A priori a Gaussian process of unit variance whose neighbouring values differ
/// little (Matern 3/2, of half the image's long side; Rasmussen and Williams 2006, Eq. 4.17).
class ImageField {
 public:
  ImageField(int width_px, int height_px);

  int knots() const { return columns_ * rows_; }
  /// The four knots around a pixel and their shares in the value there; a pixel outside counts as
  /// the nearest one of the image.
  struct Place {
    std::array<int, 4> knots;
    std::array<double, 4> shares;
  };
  Place At(const Eigen::Vector2d& pixel) const;
  /// knots x modes: the field's values are modes() * z, z of unit variance a priori; modes that
  /// hardly vary a priori are left out.
  const Eigen::MatrixXd& modes() const { return modes_; }

 private:
  int columns_, rows_;
  Eigen::Vector2d knots_per_px_;
  Eigen::MatrixXd modes_;
};

}  // namespace tagtwist::internal
