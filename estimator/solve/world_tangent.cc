#include "estimator/solve/world_tangent.h"

#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

// Entries of the error state, and of the rates.
constexpr int kPosition = 3, kVelocity = 6, kRate = 9, kThird = 12, kLast = 15;
constexpr int kRatesVelocity = 0, kRatesRate = 3, kRatesThird = 6, kRatesLast = 9;

}  // namespace

GraphStep DifferenceInWorld(const GraphState& state, const GraphState& reference,
                            PriorTangent tangent) {
  if (tangent == PriorTangent::kOwn) return Difference(state, reference);
  const Eigen::Quaterniond turn = state.pose.rotation() * reference.pose.rotation().conjugate();
  const auto of = [&](int entry) { return state.rates.segment<3>(entry); };
  const auto of_reference = [&](int entry) {
    return Eigen::Vector3d(reference.rates.segment<3>(entry));
  };
  GraphStep out;
  out.head<3>() = LogSo3(turn);
  out.segment<3>(kPosition) =
      state.pose.translation() - turn * Eigen::Vector3d(reference.pose.translation());
  out.segment<3>(kVelocity) = of(kRatesVelocity) - turn * of_reference(kRatesVelocity);
  out.segment<3>(kRate) = of(kRatesRate) - of_reference(kRatesRate);
  out.segment<3>(kThird) = tangent == PriorTangent::kWorld
                               ? of(kRatesThird) - turn * of_reference(kRatesThird)
                               : of(kRatesThird) - of_reference(kRatesThird);
  out.segment<3>(kLast) = of(kRatesLast) - of_reference(kRatesLast);
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
  out.block<3, 3>(kVelocity, 0) = moved_by_turn(reference.rates.segment<3>(kRatesVelocity));
  if (tangent == PriorTangent::kWorld) {
    out.block<3, 3>(kThird, 0) = moved_by_turn(reference.rates.segment<3>(kRatesThird));
  }
  return out;
}

}  // namespace tagtwist::internal
