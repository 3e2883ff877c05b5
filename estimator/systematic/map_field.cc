#include "estimator/systematic/map_field.h"

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <utility>

#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr double kLeastOfMapModes = 1e-4;  // variance of a mode over the largest one's
constexpr double kNoBend = 1e-9;           // places that only shift, turn and stretch have none
constexpr Eigen::Index kMostMapModes = 24;
constexpr double kStretchShift = 2;  // a stretch from a corner shifts the whole by as much
constexpr double kFlat = 0.05;       // extent along an axis over the largest one that is none

// The process' covariance over a distance in units of its length, and its derivative by half the
// square of that.
struct Covariance {
  double value, slope;
};

Covariance CovarianceOver(double distance_over_length) {
  const double q = std::sqrt(5.0) * distance_over_length;
  const double fall = std::exp(-q);
  return {(1 + q + q * q / 3) * fall, -5.0 / 3 * (1 + q) * fall};
}

// The places about their centre, one a column.
Eigen::Matrix3Xd About(const std::vector<Eigen::Vector3d>& places, const Eigen::Vector3d& centre) {
  Eigen::Matrix3Xd out(3, static_cast<Eigen::Index>(places.size()));
  for (size_t i = 0; i < places.size(); ++i) {
    out.col(static_cast<Eigen::Index>(i)) = places[i] - centre;
  }
  return out;
}

}  // namespace

MapField::MapField(std::vector<Eigen::Vector3d> places, double length_m)
    : places_(std::move(places)), length_m_(length_m), centre_(Eigen::Vector3d::Zero()) {
  const auto n = static_cast<Eigen::Index>(places_.size());
  for (const Eigen::Vector3d& place : places_) centre_ += place / static_cast<double>(n);
  Eigen::MatrixXd prior(n, n);
  for (Eigen::Index a = 0; a < n; ++a) {
    for (Eigen::Index b = 0; b < n; ++b) {
      const double apart_m =
          (places_[static_cast<size_t>(a)] - places_[static_cast<size_t>(b)]).norm();
      prior(a, b) = CovarianceOver(apart_m / length_m_).value;
    }
  }
  Eigen::MatrixXd affine(n, 4);
  const Eigen::Matrix3Xd about = About(places_, centre_);
  const double extent_m = about.norm() / std::sqrt(static_cast<double>(n));
  affine << Eigen::VectorXd::Ones(n), about.transpose() / extent_m;
  Eigen::CompleteOrthogonalDecomposition<Eigen::MatrixXd> fit;
  fit.setThreshold(kFlat);
  fit.compute(affine);
  const Eigen::MatrixXd inverse = fit.pseudoInverse();
  const Eigen::MatrixXd rest = prior - affine * (inverse * prior);
  const Eigen::MatrixXd bend = rest - (rest * inverse.transpose()) * affine.transpose();
  const double square = bend.trace() / static_cast<double>(n);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(bend);
  const Eigen::VectorXd& variances = own.eigenvalues();  // ascending
  const double least = std::max(kLeastOfMapModes * variances(n - 1), kNoBend);
  const Eigen::Index kept = std::min((variances.array() > least).count(), kMostMapModes);
  by_place_ = own.eigenvectors().rightCols(kept) *
              (square * variances.tail(kept)).cwiseSqrt().cwiseInverse().asDiagonal();
  linear_ = inverse * (prior * by_place_);
  linear_.bottomRows(3) /= extent_m;
  MakeLinear(std::sqrt(std::min(1.0, prior.mean() / square)));
}

// Turns of all places, and stretches along the axes that they have.
void MapField::MakeLinear(double rigid) {
  shift_ = rigid;
  const Eigen::Matrix3Xd about = About(places_, centre_);
  const auto n = static_cast<double>(places_.size());
  const Eigen::Matrix3d squared = about * about.transpose() / n;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(squared);
  const auto add = [&](const Linear& linear, double size, std::vector<Linear>* out) {
    const double rms = std::sqrt((linear * about).squaredNorm() / n);
    out->push_back(rms > 0 ? Linear(size / rms * linear) : Linear::Zero());
  };
  for (int a = 0; a < 3; ++a) add(Hat(Eigen::Vector3d::Unit(a)), rigid, &turns_);
  const Eigen::Vector3d& squares = axes.eigenvalues();  // ascending
  for (int a = 0; a < 3; ++a) {
    if (squares(a) < kFlat * kFlat * squares(2)) continue;
    for (int b = a; b < 3; ++b) {
      const Eigen::Matrix3d along =
          axes.eigenvectors().col(a) * axes.eigenvectors().col(b).transpose();
      add(along + along.transpose(), 1, &stretches_);
    }
  }
}

Eigen::MatrixXd MapField::BendAt(const Eigen::Vector3d& place) const {
  Eigen::MatrixXd covariances(4, by_place_.rows());
  for (Eigen::Index i = 0; i < covariances.cols(); ++i) {
    const Eigen::Vector3d apart = (place - places_[static_cast<size_t>(i)]) / length_m_;
    const Covariance over = CovarianceOver(apart.norm());
    covariances.col(i) << over.value, over.slope / length_m_ * apart;
  }
  Eigen::Matrix4d affine = Eigen::Matrix4d::Identity();
  affine.topRightCorner<1, 3>() = (place - centre_).transpose();
  return covariances * by_place_ - affine * linear_;
}

Eigen::MatrixXd MapField::OfTag(const Tag& tag) const {
  const Eigen::Matrix3d axes = tag.world_from_tag.rotation().toRotationMatrix();
  const Eigen::Vector3d place = tag.world_from_tag.translation();
  const Eigen::MatrixXd bend = BendAt(place);
  const Eigen::MatrixXd slopes = axes.leftCols<2>().transpose() * bend.bottomRows(3);
  const Eigen::Index n = bend.cols();
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(5, modes());
  for (Eigen::Index a = 0; a < 3; ++a) {
    out.block(a, a * n, 1, n) = bend.topRows(1);
    out.block(3, a * n, 2, n) = axes(a, 2) * slopes;
  }
  Eigen::Index column = 3 * n;
  const auto add_linear = [&](const Linear& linear) {
    out.col(column).head<3>() = linear * (place - centre_);
    out.col(column).tail<2>() = axes.leftCols<2>().transpose() * (linear.transpose() * axes.col(2));
    ++column;
  };
  for (const Linear& turn : turns_) add_linear(turn);
  out.block<3, 3>(0, column) = shift_ * Eigen::Matrix3d::Identity();
  column += 3;
  for (const Linear& stretch : stretches_) add_linear(stretch);
  out.block<3, 3>(0, column) = kStretchShift * Eigen::Matrix3d::Identity();
  return out;
}

Eigen::Matrix<double, 12, 2> CornersBySlopes(const Tag& tag) {
  const Eigen::Matrix3d axes = tag.world_from_tag.rotation().toRotationMatrix();
  Eigen::Matrix<double, 12, 2> out;
  for (int c = 0; c < 4; ++c) {
    const double x = (c == 1 || c == 2 ? 0.5 : -0.5) * tag.size_m;
    const double y = (c >= 2 ? 0.5 : -0.5) * tag.size_m;
    out.block<3, 1>(3 * c, 0) = x * axes.col(2);
    out.block<3, 1>(3 * c, 1) = y * axes.col(2);
  }
  return out;
}

}  // namespace tagtwist::internal
