#include "frontend/geometry/homography.h"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <cmath>

namespace tagtwist::internal {
namespace {

// Similarity that moves the points to centroid 0 and mean distance sqrt(2).
Eigen::Matrix3d HartleyTransform(const std::vector<Eigen::Vector2d>& points) {
  Eigen::Vector2d centroid = Eigen::Vector2d::Zero();
  for (const auto& point : points) centroid += point;
  centroid /= static_cast<double>(points.size());
  double distance = 0;
  for (const auto& point : points) distance += (point - centroid).norm();
  const double scale = std::sqrt(2.0) * static_cast<double>(points.size()) / distance;
  Eigen::Matrix3d transform = Eigen::Matrix3d::Identity();
  transform.diagonal().head<2>().setConstant(scale);
  transform.topRightCorner<2, 1>() = -scale * centroid;
  return transform;
}

// The 2n x 9 matrix of seed Eq. 2.
Eigen::Matrix<double, Eigen::Dynamic, 9> DltMatrix(const std::vector<Eigen::Vector2d>& points_in_a,
                                                   const std::vector<Eigen::Vector2d>& points_in_b,
                                                   const Eigen::Matrix3d& normalised_from_a,
                                                   const Eigen::Matrix3d& normalised_from_b) {
  Eigen::Matrix<double, Eigen::Dynamic, 9> rows(2 * points_in_a.size(), 9);
  for (size_t i = 0; i < points_in_a.size(); ++i) {
    const Eigen::RowVector3d a = (normalised_from_a * points_in_a[i].homogeneous()).transpose();
    const Eigen::Vector3d b = normalised_from_b * points_in_b[i].homogeneous();
    const auto row = static_cast<Eigen::Index>(2 * i);
    rows.row(row) << a, Eigen::RowVector3d::Zero(), -b.x() * a;
    rows.row(row + 1) << Eigen::RowVector3d::Zero(), a, -b.y() * a;
  }
  return rows;
}

using Vector9 = Eigen::Matrix<double, 9, 1>;

// The right singular vector of the smallest singular value, where one stands out.
std::optional<Vector9> NullVector(const Eigen::Matrix<double, Eigen::Dynamic, 9>& rows) {
  // By the normal equations, in a third of the time; squaring costs digits: 1e-10 is left.
  constexpr double kWell = 1e-6;
  const Eigen::Matrix<double, 9, 9> squares = rows.transpose() * rows;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 9, 9>> squared(squares);
  if (squared.info() == Eigen::Success &&
      squared.eigenvalues()(1) > kWell * squared.eigenvalues()(8)) {
    return Vector9(squared.eigenvectors().col(0));
  }
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(rows, Eigen::ComputeFullV);
  // Rank 8 is needed; with four points there are only eight singular values.
  const auto& values = svd.singularValues();
  if (!(values(7) > 1e-10 * values(0))) return std::nullopt;
  return Vector9(svd.matrixV().col(8));
}

}  // namespace

std::optional<Eigen::Matrix3d> FitHomography(const std::vector<Eigen::Vector2d>& points_in_a,
                                             const std::vector<Eigen::Vector2d>& points_in_b,
                                             bool normalise) {
  if (points_in_a.size() < 4 || points_in_a.size() != points_in_b.size()) return std::nullopt;
  Eigen::Matrix3d normalised_from_a = Eigen::Matrix3d::Identity();
  Eigen::Matrix3d normalised_from_b = Eigen::Matrix3d::Identity();
  if (normalise) {
    normalised_from_a = HartleyTransform(points_in_a);
    normalised_from_b = HartleyTransform(points_in_b);
  }
  const auto rows = DltMatrix(points_in_a, points_in_b, normalised_from_a, normalised_from_b);
  if (!rows.allFinite()) return std::nullopt;
  const auto h = NullVector(rows);
  if (!h) return std::nullopt;
  const Eigen::Matrix3d normalised =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(h->data());
  const Eigen::Matrix3d b_from_a = normalised_from_b.inverse() * normalised * normalised_from_a;
  return b_from_a / b_from_a.norm();
}

std::optional<Pose> PoseFromHomography(const Eigen::Matrix3d& image_from_plane,
                                       const std::vector<Eigen::Vector2d>& points_in_plane,
                                       bool seed_scale) {
  const Eigen::RowVector3d depth_row = image_from_plane.row(2);
  size_t n_in_front = 0;
  for (const auto& point : points_in_plane) {
    if (depth_row * point.homogeneous() > 0) ++n_in_front;
  }
  if (n_in_front != 0 && n_in_front != points_in_plane.size()) return std::nullopt;
  const Eigen::Matrix3d h = n_in_front == 0 ? (-image_from_plane).eval() : image_from_plane;
  const double norm_1 = h.col(0).norm(), norm_2 = h.col(1).norm();
  const double scale = seed_scale ? norm_1 : 0.5 * (norm_1 + norm_2);
  Eigen::Matrix3d frame;
  frame << h.col(0), h.col(1), h.col(0).cross(h.col(1)) / scale;
  if (!(scale > 0) || !(frame.determinant() > 0)) return std::nullopt;
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(frame, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const Eigen::Matrix3d &u = svd.matrixU(), &v = svd.matrixV();
  const Eigen::Vector3d signs(1, 1, (u * v.transpose()).determinant());
  const Eigen::Matrix3d rotation = u * signs.asDiagonal() * v.transpose();
  return MakePose(Eigen::Quaterniond(rotation), h.col(2) / scale);
}

std::optional<Pose> PoseFromTags(const std::vector<TagDetection>& tags, const TagMap& map,
                                 const Pose& world_from_plane, const Camera& camera,
                                 const HomographyPoseOptions& options) {
  const Pose plane_from_world = Inverse(world_from_plane);
  std::vector<Eigen::Vector2d> points_in_plane, points_in_image;
  for (const TagDetection& tag : tags) {
    const auto& corners_in_world = map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      const auto normalised = camera.Unproject(tag.corners[c]);
      if (!normalised) continue;
      points_in_plane.emplace_back((plane_from_world * corners_in_world[c]).head<2>());
      points_in_image.push_back(*normalised);
    }
  }
  const auto image_from_plane =
      FitHomography(points_in_plane, points_in_image, options.normalise_points);
  if (!image_from_plane) return std::nullopt;
  const auto cam_from_plane =
      PoseFromHomography(*image_from_plane, points_in_plane, options.seed_scale);
  if (!cam_from_plane) return std::nullopt;
  return world_from_plane * Inverse(*cam_from_plane);
}

}  // namespace tagtwist::internal
