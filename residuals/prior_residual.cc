#include "residuals/prior_residual.h"

#include <Eigen/Geometry>
#include <utility>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist {

PriorResidual::PriorResidual(std::vector<PriorBlock> blocks, Eigen::MatrixXd jacobian,
                             Eigen::VectorXd offset)
    : blocks_(std::move(blocks)), jacobian_(std::move(jacobian)), offset_(std::move(offset)) {
  set_num_residuals(static_cast<int>(jacobian_.rows()));
  for (const PriorBlock& block : blocks_) {
    mutable_parameter_block_sizes()->push_back(block.is_pose ? 7 : 6);
  }
}

bool PriorResidual::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  const PoseManifold manifold;
  Eigen::VectorXd difference(jacobian_.cols());
  for (size_t i = 0; i < blocks_.size(); ++i) {
    double* const d = difference.data() + 6 * i;
    if (blocks_[i].is_pose) {
      manifold.Minus(parameters[i], blocks_[i].reference.data(), d);
    } else {
      Eigen::Map<Eigen::VectorXd>(d, 6) =
          Eigen::Map<const Eigen::VectorXd>(parameters[i], 6) - blocks_[i].reference;
    }
  }
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()).noalias() =
      jacobian_ * difference + offset_;
  if (jacobians == nullptr) return true;

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    if (jacobians[i] == nullptr) continue;
    const auto columns = jacobian_.middleCols<6>(static_cast<Eigen::Index>(6 * i));
    if (!blocks_[i].is_pose) {
      Eigen::Map<RowMajor>(jacobians[i], num_residuals(), 6) = columns;
      continue;
    }
    // d theta of Log(q0^-1 q Exp(theta)) = Jr^-1(Log(q0^-1 q)) theta; translation is plain.
    Eigen::Matrix<double, 6, 6> d_difference_d_tangent = Eigen::Matrix<double, 6, 6>::Identity();
    d_difference_d_tangent.topLeftCorner<3, 3>() =
        RightJacobianInverseSo3(difference.segment<3>(static_cast<Eigen::Index>(6 * i)));
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;
    manifold.MinusJacobian(parameters[i], lift.data());
    Eigen::Map<RowMajor>(jacobians[i], num_residuals(), 7).noalias() =
        columns * (d_difference_d_tangent * lift);
  }
  return true;
}

}  // namespace tagtwist
