#include "estimator/solve/world_tangent.h"

#include <gtest/gtest.h>

#include <random>

#include "frontend/types/so3.h"

namespace tagtwist::internal::world_tangent_test {
namespace {

class WorldTangent : public ::testing::Test {
 protected:
  Eigen::Vector3d Vec(double size = 1) {
    std::normal_distribution<double> normal;
    const double x = normal(rng_), y = normal(rng_), z = normal(rng_);
    return size * Eigen::Vector3d(x, y, z);
  }
  GraphState Draw() {
    GraphState out;
    const Eigen::Vector3d translation = Vec(), rotation = Vec();
    out.pose = MakePose(ExpSo3(rotation), translation);
    out.rates << Vec(), Vec(), Vec(), Vec();
    return out;
  }
  GraphStep Step(double size) {
    GraphStep out;
    out << Vec(size), Vec(size), Vec(size), Vec(size), Vec(size), Vec(size);
    return out;
  }
  std::mt19937_64 rng_{5};
};

constexpr PriorTangent kAll[] = {PriorTangent::kOwn, PriorTangent::kWorld};

TEST_F(WorldTangent, DerivativeIsTheNumericOne) {
  constexpr double kH = 1e-6;
  for (const PriorTangent tangent : kAll) {
    const GraphState reference = Draw();
    const GraphState state = Retract(reference, Step(0.1));
    const Block by = DifferenceInWorldByStep(state, reference, tangent);
    for (int i = 0; i < kBlockSize; ++i) {
      const GraphStep step = kH * GraphStep::Unit(i);
      const GraphStep up = DifferenceInWorld(Retract(state, step), reference, tangent),
                      down = DifferenceInWorld(Retract(state, -step), reference, tangent);
      if (tangent == PriorTangent::kOwn && i < 3) continue;  // exact at the reference alone
      EXPECT_LT(((up - down) / (2 * kH) - by.col(i)).norm(), 1e-7) << i;
    }
  }
}

// A world that is turned moves every state by the same step.
TEST_F(WorldTangent, OfAWorldThatIsTurnedIsTheSameEverywhere) {
  const Eigen::Vector3d turn = Vec(0.3);
  const Eigen::Quaterniond q = ExpSo3(turn);
  for (int draw = 0; draw < 5; ++draw) {
    const GraphState state = Draw();
    GraphState turned = state;
    turned.pose = MakePose(q * state.pose.rotation(), q * state.pose.translation());
    turned.rates.head<3>() = q * state.rates.head<3>();
    GraphStep expected = GraphStep::Zero();
    expected.head<3>() = turn;
    EXPECT_LT((DifferenceInWorld(turned, state, PriorTangent::kWorld) - expected).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace tagtwist::internal::world_tangent_test
