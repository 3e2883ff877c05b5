#include "bench/plain_ceres.h"

#include <ceres/ceres.h>

#include <Eigen/Geometry>
#include <cmath>

#include "estimator/graph/noise_model.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {
namespace {

template <typename T>
using Vector3 = Eigen::Matrix<T, 3, 1>;

// One corner through a pinhole, whitened.
struct CornerCost {
  Eigen::Vector3d corner_in_world;
  Eigen::Vector2d pixel;
  double sigma_px;
  const EstimatorSetup* setup;

  template <typename T>
  bool operator()(const T* pose, T* residual) const {
    const Eigen::Map<const Eigen::Quaternion<T>> rotation(pose);
    const Eigen::Map<const Vector3<T>> position(pose + 4);
    const Vector3<T> in_body = rotation.conjugate() * (corner_in_world.cast<T>() - position);
    const Vector3<T> in_cam = setup->cam_from_body.rotation().cast<T>() * in_body +
                              setup->cam_from_body.translation().cast<T>();
    const Camera& camera = setup->camera;
    residual[0] = (camera.fx * in_cam.x() / in_cam.z() + camera.cx - pixel.x()) / sigma_px;
    residual[1] = (camera.fy * in_cam.y() / in_cam.z() + camera.cy - pixel.y()) / sigma_px;
    return true;
  }
};

// Jr^-1(phi) w, for the small turns between frames.
template <typename T>
Vector3<T> RightJacobianInverseTimes(const Vector3<T>& phi, const Vector3<T>& w) {
  const T factor = 1.0 / 12 + phi.squaredNorm() / 720.0;
  return w + 0.5 * phi.cross(w) + factor * phi.cross(phi.cross(w));
}

template <typename T>
Vector3<T> LogOf(const Eigen::Quaternion<T>& q) {
  const T squared = q.vec().squaredNorm();
  if (squared < 1e-20) return 2.0 * q.vec();
  const T norm = sqrt(squared);
  return (2.0 * atan2(norm, q.w()) / norm) * q.vec();
}

// White noise on acceleration: the errors of M6, whitened by M7.
struct MotionCost {
  double dt_s;
  Eigen::Matrix3d w_linear, w_angular;

  template <typename T>
  bool operator()(const T* pose1, const T* twist1, const T* pose2, const T* twist2, T* out) const {
    const Eigen::Map<const Eigen::Quaternion<T>> q1(pose1), q2(pose2);
    const Eigen::Map<const Vector3<T>> p1(pose1 + 4), p2(pose2 + 4), v1(twist1), v2(twist2),
        omega1(twist1 + 3), omega2(twist2 + 3);
    const Eigen::Quaternion<T> turn = q1.conjugate() * q2;
    const Vector3<T> phi = LogOf(turn);
    const Vector3<T> e_p = p2 - p1 - dt_s * v1, e_v = v2 - v1, e_theta = phi - dt_s * omega1,
                     e_omega = RightJacobianInverseTimes<T>(phi, omega2) - omega1;
    Eigen::Map<Eigen::Matrix<T, 12, 1>> residual(out);
    residual << w_linear(0, 0) * e_p + w_linear(0, 1) * e_v, w_linear(1, 1) * e_v,
        w_angular(0, 0) * e_theta + w_angular(0, 1) * e_omega, w_angular(1, 1) * e_omega;
    return true;
  }
};

using Vector6 = Eigen::Matrix<double, 6, 1>;

void AddCorners(const EstimatorSetup& setup, const NoiseModel& noise, const GraphFrame& frame,
                ceres::LossFunction* loss, ceres::Problem* problem) {
  double* pose = const_cast<double*>(frame.state.world_from_body.params.data());
  for (const TagDetection& tag : frame.tags) {
    const auto& corners = setup.map.CornersInWorld(tag.id);
    for (size_t c = 0; c < 4; ++c) {
      auto* cost = new ceres::AutoDiffCostFunction<CornerCost, 2, 7>(
          new CornerCost{corners[c], tag.corners[c], noise.corner_sigma_px, &setup});
      problem->AddResidualBlock(cost, loss, pose);
    }
  }
}

}  // namespace

bool SolvePlainly(const EstimatorSetup& setup, const NoiseModel& noise,
                  std::vector<GraphFrame>* frames) {
  ceres::Problem::Options problem_options;
  problem_options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  problem_options.manifold_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::HuberLoss loss(setup.options.robust_scale * std::sqrt(2.0));
  PoseManifold manifold;
  ceres::Problem problem(problem_options);
  std::vector<Vector6> twists(frames->size());
  for (size_t k = 0; k < frames->size(); ++k) {
    GraphFrame& frame = (*frames)[k];
    twists[k] << frame.state.twist.v_world, frame.state.twist.omega_body;
    problem.AddParameterBlock(frame.state.world_from_body.params.data(), 7, &manifold);
    AddCorners(setup, noise, frame, &loss, &problem);
    if (k == 0) continue;
    GraphFrame& before = (*frames)[k - 1];
    const double dt_s = ToSeconds(frame.t_ns - before.t_ns);
    auto* cost = new ceres::AutoDiffCostFunction<MotionCost, 12, 7, 6, 7, 6>(new MotionCost{
        dt_s, RootInformation(noise.linear, dt_s), RootInformation(noise.angular, dt_s)});
    problem.AddResidualBlock(cost, nullptr, before.state.world_from_body.params.data(),
                             twists[k - 1].data(), frame.state.world_from_body.params.data(),
                             twists[k].data());
  }
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  for (size_t k = 0; k < frames->size(); ++k) {
    (*frames)[k].state.twist = {twists[k].head<3>(), twists[k].tail<3>()};
  }
  return summary.IsSolutionUsable();
}

}  // namespace tagtwist::internal
