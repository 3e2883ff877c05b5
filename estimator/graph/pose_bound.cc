#include "estimator/graph/pose_bound.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

// A direction whose information is this small beside the others', each in its own unit, is not
// fixed.
constexpr double kLeastInformation = 1e-11;

}  // namespace

std::optional<PoseCovariance> InverseInformation(const PoseCovariance& information) {
  const Eigen::Matrix<double, 6, 1> scale = information.diagonal().cwiseSqrt().cwiseInverse();
  if (!scale.allFinite()) return std::nullopt;
  const PoseCovariance scaled = scale.asDiagonal() * information * scale.asDiagonal();
  // Most are far from singular, and then it takes a tenth of the time.
  constexpr double kFarFromSingular = 1e-6;
  const Eigen::LLT<PoseCovariance> llt(scaled);
  if (llt.info() == Eigen::Success && llt.rcond() > kFarFromSingular) {
    const PoseCovariance root = llt.matrixL().solve(PoseCovariance(scale.asDiagonal()));
    return PoseCovariance(root.transpose().lazyProduct(root));
  }
  const Eigen::SelfAdjointEigenSolver<PoseCovariance> eigen(scaled);
  if (eigen.info() != Eigen::Success || !(eigen.eigenvalues()(0) > kLeastInformation)) {
    return std::nullopt;
  }
  const PoseCovariance half = scale.asDiagonal() * eigen.eigenvectors() *
                              eigen.eigenvalues().cwiseSqrt().cwiseInverse().asDiagonal();
  return PoseCovariance(half * half.transpose());
}

std::optional<PoseInformation> InformationOfTags(const EstimatorSetup& setup,
                                                 double corner_sigma_px,
                                                 const Pose& world_from_body,
                                                 const std::vector<TagDetection>& tags) {
  PoseInformation out;
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> whitened;
  const FixedCameras cameras(setup);
  for (const TagDetection& tag : tags) {
    const TagReprojection cost({setup.map.CornersInWorld(tag.id), tag.corners,
                                CornerCovariance(setup, tag, corner_sigma_px)},
                               cameras.Of(tag.camera));
    if (!cost.Linearize(world_from_body.params.data(), &residual, &whitened)) return std::nullopt;
    out.information += whitened.transpose().lazyProduct(whitened);
    out.score -= whitened.transpose().lazyProduct(residual);
    out.squared += residual.squaredNorm();
  }
  return out;
}

std::optional<PoseCovariance> PoseBound(const EstimatorSetup& setup, double corner_sigma_px,
                                        const Pose& world_from_body,
                                        const std::vector<TagDetection>& tags) {
  const auto told = InformationOfTags(setup, corner_sigma_px, world_from_body, tags);
  return told ? InverseInformation(told->information) : std::nullopt;
}

}  // namespace tagtwist::internal
