#include "estimator/systematic/image_field.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace tagtwist::internal {
namespace {

constexpr int kKnotsOfLongSide = 10;
constexpr double kLengthOverLongSide = 0.5;
constexpr double kLeastOfModes = 1e-3;  // variance of a mode over the largest one's

int KnotsOf(int side_px, int long_side_px) {
  return std::max(2, static_cast<int>(std::lround(double{kKnotsOfLongSide} * side_px /
                                                  std::max(1, long_side_px))));
}

double Matern(double distance_over_length) {
  const double q = std::sqrt(3.0) * distance_over_length;
  return (1 + q) * std::exp(-q);
}

}  // namespace

ImageField::ImageField(int width_px, int height_px)
    : columns_(KnotsOf(width_px, std::max(width_px, height_px))),
      rows_(KnotsOf(height_px, std::max(width_px, height_px))),
      knots_per_px_((columns_ - 1) / std::max(1.0, width_px - 1.0),
                    (rows_ - 1) / std::max(1.0, height_px - 1.0)) {
  const double length_px = kLengthOverLongSide * std::max(width_px, height_px);
  Eigen::MatrixXd prior(knots(), knots());
  for (int a = 0; a < knots(); ++a) {
    for (int b = 0; b < knots(); ++b) {
      const Eigen::Vector2d apart_px =
          Eigen::Vector2d(a % columns_ - b % columns_, a / columns_ - b / columns_)
              .cwiseQuotient(knots_per_px_);
      prior(a, b) = Matern(apart_px.norm() / length_px);
    }
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(prior);
  const Eigen::VectorXd& variances = eigen.eigenvalues();  // ascending
  const double least = kLeastOfModes * variances(knots() - 1);
  const auto n = static_cast<int>((variances.array() > least).count());
  modes_ = eigen.eigenvectors().rightCols(n) * variances.tail(n).cwiseSqrt().asDiagonal();
}

ImageField::Place ImageField::At(const Eigen::Vector2d& pixel) const {
  const Eigen::Vector2d last(columns_ - 1, rows_ - 1);
  const Eigen::Vector2d at =
      pixel.cwiseProduct(knots_per_px_).cwiseMax(Eigen::Vector2d::Zero()).cwiseMin(last);
  const int column = std::min(static_cast<int>(at.x()), columns_ - 2);
  const int row = std::min(static_cast<int>(at.y()), rows_ - 2);
  const double a = at.x() - column, b = at.y() - row;
  const int k = row * columns_ + column;
  return {{k, k + 1, k + columns_, k + columns_ + 1},
          {(1 - a) * (1 - b), a * (1 - b), (1 - a) * b, a * b}};
}

}  // namespace tagtwist::internal
