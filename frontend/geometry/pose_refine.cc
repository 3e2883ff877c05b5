#include "frontend/geometry/pose_refine.h"

#include <limits>
#include <optional>

#include "frontend/base/least_squares.h"

namespace tagtwist::internal {
namespace {

// For SolveLeastSquares: the points' reprojection, in Pose's tangent of cam_from_world.
struct Reprojection {
  using State = Pose;
  using Normals = QuadraticForm<6>;

  const std::vector<PointInImage>& points;
  const Camera& camera;

  std::optional<Normals> Linearise(const Pose& cam_from_world) const {
    Normals out;
    const Eigen::Matrix3d rotation = cam_from_world.rotation().toRotationMatrix();
    for (const PointInImage& point : points) {
      Eigen::Vector2d predicted;
      Eigen::Matrix<double, 2, 3> d_pixel_d_cam;
      const Eigen::Vector3d point_in_cam =
          rotation * point.point_in_world + cam_from_world.translation();
      if (!camera.Project(point_in_cam, &predicted, &d_pixel_d_cam)) return std::nullopt;
      const Eigen::Matrix<double, 2, 3> d_pixel_d_world = d_pixel_d_cam.lazyProduct(rotation);
      Eigen::Matrix<double, 2, 6> jacobian;
      for (int i = 0; i < 2; ++i) {  // -a' Hat(p) = (p x a)'
        jacobian.row(i).head<3>() = point.point_in_world.cross(d_pixel_d_world.row(i).transpose());
      }
      jacobian.rightCols<3>() = d_pixel_d_cam;
      const Eigen::Vector2d error = predicted - point.pixel;
      out.Add(jacobian, error, 0.5 * error.squaredNorm());
    }
    return out;
  }
  static std::optional<LeastSquaresStep<PoseStep>> Solve(const Pose& /*cam_from_world*/,
                                                         double damping, Normals* normals) {
    constexpr double kNoMove = 1e-9;  // rad and m
    auto step = DampedStep(*normals, damping);
    if (step) step->is_last = step->dx.norm() < kNoMove;
    return step;
  }
  static Pose Step(const Pose& cam_from_world, const PoseStep& dx) {
    return Retract(cam_from_world, dx);
  }
};

}  // namespace

RefinedPose RefinePose(const Pose& cam_from_world, const std::vector<PointInImage>& points,
                       const Camera& camera) {
  LeastSquaresOptions options;
  options.max_steps = 60;  // a small tag's two minima lie in long flat valleys
  options.first_damping = 1e-6;
  options.relative_tolerance = 1e-8;
  Reprojection problem{points, camera};
  const auto found = SolveLeastSquares(problem, cam_from_world, options);
  if (found.end == LeastSquaresEnd::kNotEvaluable) {
    return {cam_from_world, std::numeric_limits<double>::infinity()};
  }
  return {found.x, 2 * found.cost};
}

}  // namespace tagtwist::internal
