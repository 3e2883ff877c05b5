#include "estimator/bound.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "estimator/graph_builder.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist {
namespace {

// A direction whose information is this small beside the others', each in its own unit, is not
// fixed.
constexpr double kLeastInformation = 1e-11;

// Inverse of an information matrix, or nullopt where it is singular.
std::optional<PoseCovariance> Invert(const PoseCovariance& information) {
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

}  // namespace

std::optional<PoseCovariance> PoseBound(const EstimatorSetup& setup, double corner_sigma_px,
                                        const Pose& world_from_body,
                                        const std::vector<TagDetection>& tags) {
  PoseCovariance information = PoseCovariance::Zero();
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> whitened;
  for (const TagDetection& tag : tags) {
    const TagReprojectionResidual cost({setup.map.CornersInWorld(tag.id), tag.corners,
                                        CornerCovariance(setup, tag, corner_sigma_px)},
                                       setup.camera, setup.cam_from_body);
    if (!cost.Linearize(world_from_body.params.data(), &residual, &whitened)) return std::nullopt;
    information += whitened.transpose().lazyProduct(whitened);
  }
  return Invert(information);
}

ErrorBound RmsBound(const std::vector<StateCovariance>& covariances) {
  ErrorBound out;
  out.frames = covariances.size();
  if (covariances.empty()) return out;
  StateVector sum = StateVector::Zero();
  for (const StateCovariance& p : covariances) sum += p.diagonal();
  const auto rms = [&](int first) {
    return std::sqrt(sum.segment<3>(first).sum() / static_cast<double>(covariances.size()));
  };
  out.rotation_rad = rms(0);
  out.position_m = rms(3);
  out.velocity_mps = rms(6);
  out.rate_radps = rms(9);
  return out;
}

EstimateBounds BoundsOf(const Estimate& estimate) {
  const bool window = !estimate.lagged.empty();
  std::vector<StateCovariance> alone, posterior;
  for (const FrameEstimate& f : window ? estimate.lagged : estimate.frames) {
    if (f.status == FrameStatus::kNoFix) continue;
    posterior.push_back(f.covariance);
    if (!f.pose_bound) continue;
    alone.push_back(StateCovariance::Zero());
    alone.back().topLeftCorner<6, 6>() = *f.pose_bound;
  }
  return {RmsBound(alone), RmsBound(posterior), window ? "optimised_lagged" : "optimised"};
}

HalfNoiseGain GainOfHalfNoise(WhiteNoiseOn on) {
  // With n integrators between white noise and pose, the standard deviation of derivative k goes
  // with the corner noise to the power 1 - (2 k + 1) / (2 n).
  const double n = on == WhiteNoiseOn::kJerk ? 3 : 2;
  return {std::pow(2.0, 1 - 1 / (2 * n)), std::pow(2.0, 1 - 3 / (2 * n))};
}

}  // namespace tagtwist
