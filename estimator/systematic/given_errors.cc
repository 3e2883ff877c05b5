#include "estimator/systematic/given_errors.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "residuals/lens.h"

namespace tagtwist::internal {

Eigen::MatrixXd RootOfGiven(const MountedCamera& camera, const EstimatorOptions& options) {
  constexpr double kLeastShare = 1e-12;  // of the largest eigenvalue, each entry in its own sigma
  constexpr int kMountEntries = 6;
  const Eigen::Index n = LensSize(camera.camera) + kMountEntries;
  Eigen::MatrixXd covariance = camera.covariance;
  if (covariance.rows() != n) covariance.setZero(n, n);
  if (options.focal_sigma) {
    covariance.row(kLogFocal).setZero();
    covariance.col(kLogFocal).setZero();
    covariance(kLogFocal, kLogFocal) = *options.focal_sigma * *options.focal_sigma;
  }
  const Eigen::VectorXd sigmas = covariance.diagonal().cwiseMax(0).cwiseSqrt();
  if (sigmas.isZero(0)) return Eigen::MatrixXd::Zero(n, 1);
  const Eigen::VectorXd inverse = (sigmas.array() > 0).select(sigmas.cwiseInverse(), 0.0);
  const Eigen::MatrixXd correlations = inverse.asDiagonal() * covariance * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> own(correlations);
  const Eigen::VectorXd& values = own.eigenvalues();  // ascending
  const Eigen::Index kept = (values.array() > kLeastShare * values(n - 1)).count();
  return sigmas.asDiagonal() * own.eigenvectors().rightCols(kept) *
         values.tail(kept).cwiseSqrt().asDiagonal();
}

Eigen::MatrixXd CornersByEntries(const EstimatorSetup& setup, const Pose& world_from_body,
                                 const TagDetection& tag,
                                 const Eigen::Matrix<double, 8, 6>& by_mount) {
  const MountedCamera seen_by = setup.CameraOf(tag.camera);
  const Eigen::Index lens = LensSize(seen_by.camera);
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(8, lens + 6);
  const Pose cam_from_map = seen_by.CamFromMap(world_from_body);
  const auto& corners = setup.map.CornersInWorld(tag.id);
  for (Eigen::Index c = 0; c < 4; ++c) {
    const Eigen::Vector3d point_in_cam = cam_from_map * corners[static_cast<size_t>(c)];
    Eigen::Vector2d pixel;
    if (!seen_by.camera.Project(point_in_cam, &pixel)) continue;
    out.block(2 * c, 0, 2, lens) = PixelByLens(seen_by.camera, point_in_cam, pixel);
  }
  // The mount's own step is a turn in the body, as that is, and a shift in the camera.
  out.middleCols(lens, 3) = by_mount.leftCols<3>();
  out.rightCols(3) =
      by_mount.rightCols<3>() * seen_by.cam_from_body.rotation().toRotationMatrix().transpose();
  return out;
}

}  // namespace tagtwist::internal
