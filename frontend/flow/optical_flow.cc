#include "frontend/flow/optical_flow.h"

#include <Eigen/QR>
#include <numeric>

#include "frontend/types/ray.h"

namespace tagtwist::internal {

Eigen::Matrix<double, 2, 6> InteractionMatrix(const Eigen::Vector2d& point, double depth_m) {
  const double x = point.x(), y = point.y(), iz = 1 / depth_m;
  Eigen::Matrix<double, 2, 6> rows;
  rows << -iz, 0, x * iz, x * y, -(1 + x * x), y,  //
      0, -iz, y * iz, 1 + y * y, -x * y, -x;
  return rows;
}

std::optional<double> DepthOnPlane(const Eigen::Vector2d& point, const Pose& cam_from_plane) {
  const Eigen::Vector3d normal_in_cam = cam_from_plane.rotation() * Eigen::Vector3d::UnitZ();
  const double depth_m =
      DistanceToPlane({Eigen::Vector3d::Zero(), point.homogeneous()}, normal_in_cam,
                      normal_in_cam.dot(cam_from_plane.translation()));
  constexpr double kMaxDepthM = 1e3;  // rays that graze the plane
  if (!(depth_m > 1e-3 && depth_m < kMaxDepthM)) return std::nullopt;
  return depth_m;
}

std::optional<CameraTwist> SolveTwist(const std::vector<FlowPoint>& flow,
                                      const std::vector<size_t>& indices) {
  if (indices.size() < 3) return std::nullopt;
  Eigen::Matrix<double, Eigen::Dynamic, 6> rows(2 * indices.size(), 6);
  Eigen::VectorXd rates(2 * indices.size());
  Eigen::Index row = 0;
  for (const size_t i : indices) {
    rows.middleRows<2>(row) = InteractionMatrix(flow[i].point, flow[i].depth_m);
    rates.segment<2>(row) = flow[i].flow;
    row += 2;
  }
  Eigen::ColPivHouseholderQR<Eigen::Matrix<double, Eigen::Dynamic, 6>> qr(rows);
  qr.setThreshold(1e-6);
  if (qr.rank() < 6) return std::nullopt;
  const CameraTwist twist = qr.solve(rates);
  if (!twist.allFinite()) return std::nullopt;
  return twist;
}

std::optional<CameraTwist> SolveTwist(const std::vector<FlowPoint>& flow) {
  std::vector<size_t> all(flow.size());
  std::iota(all.begin(), all.end(), size_t{0});
  return SolveTwist(flow, all);
}

Twist BodyTwist(const CameraTwist& twist_of_cam_in_cam, const Pose& cam_from_body,
                const Pose& world_from_body) {
  const Eigen::Vector3d v_cam = twist_of_cam_in_cam.head<3>();
  const Eigen::Vector3d omega_in_cam = twist_of_cam_in_cam.tail<3>();
  const Eigen::Quaterniond body_from_cam = cam_from_body.rotation().conjugate();
  // The body's origin sits at cam_from_body.translation() in C: v = v_cam - S(r) omega.
  const Eigen::Vector3d v_body_in_cam = v_cam + omega_in_cam.cross(cam_from_body.translation());
  return {world_from_body.rotation() * (body_from_cam * v_body_in_cam),
          body_from_cam * omega_in_cam};
}

Twist TwistSeenFrom(const CameraTwist& twist_of_cam_in_cam, const Pose& cam_from_world,
                    const Pose& world_from_body) {
  const Pose cam_from_body = cam_from_world * world_from_body;
  const Eigen::Vector3d v_cam = twist_of_cam_in_cam.head<3>();
  const Eigen::Vector3d omega_in_cam = twist_of_cam_in_cam.tail<3>();
  const Eigen::Vector3d v_body_in_cam = v_cam + omega_in_cam.cross(cam_from_body.translation());
  return {-(cam_from_world.rotation().conjugate() * v_body_in_cam),
          -(cam_from_body.rotation().conjugate() * omega_in_cam)};
}

Twist LowPass(const Twist& past, const Twist& now, double alpha) {
  return {alpha * past.v_world + (1 - alpha) * now.v_world,
          alpha * past.omega_body + (1 - alpha) * now.omega_body};
}

}  // namespace tagtwist::internal
