#pragma once
#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <vector>

namespace tagtwist::internal {

/// One parameter block of a prior and the value it was linearised at.
struct PriorBlock {
  bool is_pose = false;  // 7 parameters on the PoseManifold, tangent 6; else plain ones (rates)
  Eigen::VectorXd reference;  // the parameters
};

/// Gaussian prior on poses and rates, as marginalisation leaves it:
///   r = jacobian * d + offset,   d = stacked differences of the blocks from their references
/// (pose: the tangent of pose.h; rates: plain). Rows: those of jacobian, which has a column for
/// each entry of d.
/// The references stay where the prior was linearised: first estimates, for consistency.
class PriorResidual final : public ceres::CostFunction {
 public:
  PriorResidual(std::vector<PriorBlock> blocks, Eigen::MatrixXd jacobian, Eigen::VectorXd offset);
  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override;

 private:
  std::vector<PriorBlock> blocks_;
  Eigen::MatrixXd jacobian_;
  Eigen::VectorXd offset_;
};

}  // namespace tagtwist::internal
