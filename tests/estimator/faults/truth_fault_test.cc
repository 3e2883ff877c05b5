// A smooth path estimated with noise of millimetres, against truth with one mistake.
#include "estimator/evaluation/truth_fault.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "frontend/types/so3.h"
#include "tests/support/draws.h"

namespace tagtwist::internal::truth_fault_test {
namespace {

using ::testing::HasSubstr;
using Truth = std::vector<TruthSample>;

Pose PoseAt(double t_s) {
  const Eigen::Vector3d p(1.5 + std::sin(t_s), 1.2 + 0.7 * std::sin(2 * t_s),
                          1 + 0.2 * std::cos(t_s));
  return MakePose(
      ExpSo3(Eigen::Vector3d(0.2 * std::sin(t_s), 0.3 * std::cos(1.3 * t_s), 0.4 * t_s)), p);
}

Pose Mount() {
  return MakePose(ExpSo3(Eigen::Vector3d(0.4, 1.2, -0.3)), Eigen::Vector3d(0.05, -0.02, 0.03));
}

PoseSeries Estimated() {
  std::mt19937 random(3);
  std::normal_distribution<double> normal(0, 1);
  PoseSeries out;
  for (int i = 0; i < 200; ++i) {
    const Pose pose = PoseAt(0.05 * i);
    const Eigen::Vector3d off = DrawVector<3>(normal, random);
    const Eigen::Vector3d turn = DrawVector<3>(normal, random);
    out.push_back({i * 50'000'000LL,
                   MakePose(pose.rotation() * ExpSo3(2e-3 * turn), pose.translation() + 2e-3 * off),
                   {},
                   {}});
  }
  return out;
}

template <typename Mistake>
Truth TruthWith(Mistake&& mistake, double clock_s = 0) {
  Truth out;
  for (int i = -100; i < 1100; ++i) {
    const double t_s = 0.01 * i;
    out.push_back({std::llround(1e9 * (t_s + clock_s)), mistake(PoseAt(t_s)), {}});
  }
  return out;
}

std::string FaultOf(const Truth& truth) {
  const auto fault = FindTruthFault(Estimated(), truth, Mount(), 0.1);
  return fault ? fault->fact : "";
}

Pose With(const Pose& pose, const Eigen::Vector4d& xyzw) {
  return MakePose(Eigen::Quaterniond(xyzw(3), xyzw(0), xyzw(1), xyzw(2)), pose.translation());
}

TEST(TruthFault, RightTruthIsLeftAlone) {
  EXPECT_EQ(FaultOf(TruthWith([](const Pose& pose) { return pose; })), "");
}

// What a marker's place, a rough mount and a laggard clock do is no person's mistake.
TEST(TruthFault, SmallDifferencesAreLeftAlone) {
  EXPECT_EQ(FaultOf(TruthWith([](const Pose& pose) {
              return pose * MakePose(ExpSo3(Eigen::Vector3d(0, 0, 0.03)), {0.01, 0.015, 0});
            })),
            "");
  EXPECT_EQ(FaultOf(TruthWith([](const Pose& pose) { return pose; }, 0.01)), "");
}

TEST(TruthFault, NamesTheUnit) {
  const std::string fault = FaultOf(TruthWith([](const Pose& pose) {
    return MakePose(pose.rotation(), 1e3 * Eigen::Vector3d(pose.translation()));
  }));
  EXPECT_THAT(fault, HasSubstr("in millimetres"));
}

// A sheet that was printed to fit the page, and a map in inches; a marker beside the body is none.
TEST(TruthFault, NamesAMapOfAnotherScale) {
  const auto with = [](double scale) {
    return FaultOf(TruthWith([&](const Pose& pose) {
      return MakePose(pose.rotation(), scale * Eigen::Vector3d(pose.translation()));
    }));
  };
  EXPECT_THAT(with(0.97), HasSubstr("The ground truth moves 0.97"));
  EXPECT_THAT(with(0.0254), HasSubstr("The ground truth moves 0.025"));
  EXPECT_THAT(FaultOf(TruthWith([](const Pose& pose) {
                return pose * MakePose(ExpSo3({0, 0, 0}), {0.1, 0.02, 0.1});
              })),
              testing::Not(HasSubstr("times as far")));
}

TEST(TruthFault, NamesQuaternionsWithWFirst) {
  EXPECT_THAT(FaultOf(TruthWith([](const Pose& pose) {
                const Eigen::Vector4d q = pose.rotation().coeffs();
                return With(pose, {q(3), q(0), q(1), q(2)});
              })),
              HasSubstr("when w is read first"));
  EXPECT_THAT(FaultOf(TruthWith([](const Pose& pose) {
                return MakePose(pose.rotation().conjugate(), pose.translation());
              })),
              HasSubstr("of their inverses"));
}

TEST(TruthFault, NamesAWorldWithYUp) {
  const Pose turn = MakePose(ExpSo3(Eigen::Vector3d(-M_PI / 2, 0, 0)), {0, 0, 0});
  EXPECT_THAT(FaultOf(TruthWith([&](const Pose& pose) { return turn * pose; })),
              HasSubstr("its x, y, z run along our x, z, -y: y is up there"));
}

TEST(TruthFault, NamesAnInvertedMount) {
  // Truth is of the body; the estimate was made with the inverse of the mount.
  EXPECT_THAT(FaultOf(TruthWith(
                  [](const Pose& pose) { return pose * Inverse(Mount()) * Inverse(Mount()); })),
              HasSubstr("With the mount inverted"));
}

TEST(TruthFault, NamesAnotherClock) {
  EXPECT_THAT(FaultOf(TruthWith([](const Pose& pose) { return pose; }, 0.75)),
              HasSubstr("clock is 0.750 s ahead"));
}

}  // namespace
}  // namespace tagtwist::internal::truth_fault_test
