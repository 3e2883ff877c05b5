#include "estimator/solve/world_tangent.h"

#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr int kPosition = 3, kVelocity = 6;  // entries of the error state

}  // namespace

GraphStep DifferenceInWorld(const GraphState& state, const GraphState& reference,
                            PriorTangent tangent) {
  if (tangent == PriorTangent::kOwn) return Difference(state, reference);
  const Eigen::Quaterniond turn = state.pose.rotation() * reference.pose.rotation().conjugate();
  GraphStep out;
  out.head<3>() = LogSo3(turn);
  out.segment<3>(kPosition) =
      state.pose.translation() - turn * Eigen::Vector3d(reference.pose.translation());
  out.segment<3>(kVelocity) =
      state.rates.head<3>() - turn * Eigen::Vector3d(reference.rates.head<3>());
  out.tail<9>() = state.rates.tail<9>() - reference.rates.tail<9>();
  return out;
}

Block DifferenceInWorldByStep(const GraphState& state, const GraphState& reference,
                              PriorTangent tangent) {
  Block out = Block::Identity();
  if (tangent == PriorTangent::kOwn) return out;
  const Eigen::Matrix3d rotation = state.pose.rotation().toRotationMatrix();
  const Eigen::Matrix3d turn = rotation * reference.pose.rotation().toRotationMatrix().transpose();
  // A step turns by theta in the body, by R theta in W, and the reference with it.
  const auto moved_by_turn = [&](const Eigen::Vector3d& of_reference) {
    return Eigen::Matrix3d(Hat(turn * of_reference) * rotation);
  };
  const Eigen::Vector3d left = LogSo3(Eigen::Quaterniond(turn));
  out.topLeftCorner<3, 3>() = RightJacobianInverseSo3(-left) * rotation;
  out.block<3, 3>(kPosition, 0) = moved_by_turn(reference.pose.translation());
  out.block<3, 3>(kVelocity, 0) = moved_by_turn(reference.rates.head<3>());
  return out;
}

}  // namespace tagtwist::internal
