#include "frontend/geometry/pose_refine.h"

#include <Eigen/Cholesky>
#include <limits>

namespace tagtwist {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// Normal equations in Pose's tangent of cam_from_world.
struct Linearised {
  Matrix6 information = Matrix6::Zero();
  Vector6 gradient = Vector6::Zero();
  double squared_error_px2 = 0;
};

Linearised Linearise(const Pose& cam_from_world, const std::vector<PointInImage>& points,
                     const Camera& camera) {
  Linearised out;
  const Eigen::Matrix3d rotation = cam_from_world.rotation().toRotationMatrix();
  for (const PointInImage& point : points) {
    Eigen::Vector2d predicted;
    Eigen::Matrix<double, 2, 3> d_pixel_d_cam;
    const Eigen::Vector3d point_in_cam =
        rotation * point.point_in_world + cam_from_world.translation();
    if (!camera.Project(point_in_cam, &predicted, &d_pixel_d_cam)) {
      out.squared_error_px2 = std::numeric_limits<double>::infinity();
      return out;
    }
    const Eigen::Matrix<double, 2, 3> d_pixel_d_world = d_pixel_d_cam.lazyProduct(rotation);
    Eigen::Matrix<double, 2, 6> jacobian;
    for (int i = 0; i < 2; ++i) {  // -a' Hat(p) = (p x a)'
      jacobian.row(i).head<3>() = point.point_in_world.cross(d_pixel_d_world.row(i).transpose());
    }
    jacobian.rightCols<3>() = d_pixel_d_cam;
    const Eigen::Vector2d error = predicted - point.pixel;
    out.information += jacobian.transpose().lazyProduct(jacobian);
    out.gradient += jacobian.transpose().lazyProduct(error);
    out.squared_error_px2 += error.squaredNorm();
  }
  return out;
}

}  // namespace

RefinedPose RefinePose(const Pose& cam_from_world, const std::vector<PointInImage>& points,
                       const Camera& camera) {
  constexpr int kMaxSteps = 20;
  RefinedPose best{cam_from_world, 0};
  Linearised at_best = Linearise(cam_from_world, points, camera);
  double damping = 1e-6;
  for (int i = 0; i < kMaxSteps && std::isfinite(at_best.squared_error_px2); ++i) {
    Matrix6 damped = at_best.information;
    damped.diagonal() *= 1 + damping;
    const Vector6 step = -damped.ldlt().solve(at_best.gradient);
    const Pose moved = Retract(best.cam_from_world, step);
    const Linearised at_moved = Linearise(moved, points, camera);
    if (!(at_moved.squared_error_px2 <= at_best.squared_error_px2)) {
      damping = damping < 1e-3 ? 1e-3 : 10 * damping;
      continue;
    }
    const double gain = at_best.squared_error_px2 - at_moved.squared_error_px2;
    best.cam_from_world = moved;
    at_best = at_moved;
    damping *= 0.1;
    if (gain <= 1e-8 * at_best.squared_error_px2 || step.norm() < 1e-9) break;
  }
  best.squared_error_px2 = at_best.squared_error_px2;
  return best;
}

}  // namespace tagtwist
