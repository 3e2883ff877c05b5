#pragma once
#include <ceres/cost_function.h>

#include <Eigen/Core>
#include <memory>
#include <utility>

namespace tagtwist::internal {

/// Another residual and a constant: what it says under something that has moved on, to first order,
/// of which it has no parameter.
class ShiftedResidual final : public ceres::CostFunction {
 public:
  ShiftedResidual(std::shared_ptr<const ceres::CostFunction> at_first, Eigen::VectorXd shift)
      : at_first_(std::move(at_first)), shift_(std::move(shift)) {
    set_num_residuals(at_first_->num_residuals());
    *mutable_parameter_block_sizes() = at_first_->parameter_block_sizes();
  }

  bool Evaluate(double const* const* parameters, double* residuals,
                double** jacobians) const override {
    if (!at_first_->Evaluate(parameters, residuals, jacobians)) return false;
    Eigen::Map<Eigen::VectorXd>(residuals, shift_.size()) += shift_;
    return true;
  }

  const std::shared_ptr<const ceres::CostFunction>& at_first() const { return at_first_; }
  const Eigen::VectorXd& shift() const { return shift_; }

 private:
  std::shared_ptr<const ceres::CostFunction> at_first_;
  Eigen::VectorXd shift_;
};

}  // namespace tagtwist::internal
