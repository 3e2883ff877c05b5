#include "residuals/prior_residual.h"

#include <Eigen/Geometry>
#include <utility>

#include "frontend/types/so3.h"
#include "residuals/pose_manifold.h"

namespace tagtwist::internal {
namespace {

Eigen::Index TangentSize(const PriorBlock& block) {
  return block.is_pose ? 6 : block.reference.size();
}

}  // namespace

PriorResidual::PriorResidual(std::vector<PriorBlock> blocks, Eigen::MatrixXd jacobian,
                             Eigen::VectorXd offset)
    : blocks_(std::move(blocks)), jacobian_(std::move(jacobian)), offset_(std::move(offset)) {
  set_num_residuals(static_cast<int>(jacobian_.rows()));
  for (const PriorBlock& block : blocks_) {
    mutable_parameter_block_sizes()->push_back(static_cast<int>(block.reference.size()));
  }
}

bool PriorResidual::Evaluate(double const* const* parameters, double* residuals,
                             double** jacobians) const {
  const PoseManifold manifold;
  Eigen::VectorXd difference(jacobian_.cols());
  Eigen::Index column = 0;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const Eigen::Index size = TangentSize(blocks_[i]);
    if (blocks_[i].is_pose) {
      manifold.Minus(parameters[i], blocks_[i].reference.data(), difference.data() + column);
    } else {
      difference.segment(column, size) =
          Eigen::Map<const Eigen::VectorXd>(parameters[i], size) - blocks_[i].reference;
    }
    column += size;
  }
  Eigen::Map<Eigen::VectorXd>(residuals, num_residuals()).noalias() =
      jacobian_ * difference + offset_;
  if (jacobians == nullptr) return true;

  using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  column = 0;
  for (size_t i = 0; i < blocks_.size(); ++i) {
    const Eigen::Index first = column, size = TangentSize(blocks_[i]);
    column += size;
    if (jacobians[i] == nullptr) continue;
    const auto columns = jacobian_.middleCols(first, size);
    if (!blocks_[i].is_pose) {
      Eigen::Map<RowMajor>(jacobians[i], num_residuals(), size) = columns;
      continue;
    }
    // d theta of Log(q0^-1 q Exp(theta)) = Jr^-1(Log(q0^-1 q)) theta; translation is plain.
    Eigen::Matrix<double, 6, 6> d_difference_d_tangent = Eigen::Matrix<double, 6, 6>::Identity();
    d_difference_d_tangent.topLeftCorner<3, 3>() =
        RightJacobianInverseSo3(difference.segment<3>(first));
    Eigen::Matrix<double, 6, 7, Eigen::RowMajor> lift;
    manifold.MinusJacobian(parameters[i], lift.data());
    Eigen::Map<RowMajor>(jacobians[i], num_residuals(), 7).noalias() =
        columns * (d_difference_d_tangent * lift);
  }
  return true;
}

}  // namespace tagtwist::internal
