#include "estimator/evaluation/hand_eye.h"

#include <gtest/gtest.h>

#include "frontend/types/so3.h"
#include "tests/support/evaluation_data.h"

namespace tagtwist::internal::hand_eye_test {
namespace {

const Pose kTruthFromWorld = MakePose(ExpSo3({-0.2, 0.4, 1.5}), {2, 1, -0.5});
const Pose kBodyFromMarker = MakePose(ExpSo3({0.3, -0.7, 0.2}), {0.05, 0.02, -0.1});

std::vector<TruthSample> MarkerTruth() {
  std::vector<TruthSample> out;
  for (const TruthSample& s : SmoothTruth(10, 100)) {
    out.push_back({s.t_ns, kTruthFromWorld * s.world_from_body * kBodyFromMarker, s.twist});
  }
  return out;
}

AlignmentOptions Options() {
  AlignmentOptions out;
  out.kind = AlignmentKind::kHandEye;
  return out;
}

double Distance(const Pose& a, const Pose& b) {
  return LogSo3(a.rotation().conjugate() * b.rotation()).norm() +
         (a.translation() - b.translation()).norm();
}

// Of two starts the one that is far off does not matter.
TEST(HandEye, GoesFromTheBestOfItsStartsToTheOptimum) {
  Alignment near, far;
  near.truth_from_world = MakePose(ExpSo3({-0.1, 0.3, 1.4}), {1.9, 1.1, -0.4});
  near.body_from_marker = MakePose(ExpSo3({0.2, -0.6, 0.1}), {0, 0, 0});
  far.truth_from_world = MakePose(ExpSo3({3, 0, 0}), {-5, 0, 0});
  for (const auto& starts : {std::vector<Alignment>{near}, {far, near}, {near, far}}) {
    const auto found = AlignHandEye(SmoothSeries(0, 400, 50), MarkerTruth(), starts, Options());
    ASSERT_TRUE(found) << found.error().message;
    EXPECT_LT(Distance(found->truth_from_world, kTruthFromWorld), 1e-5);
    EXPECT_LT(Distance(found->body_from_marker, kBodyFromMarker), 1e-5);
  }
}

TEST(HandEye, FewerThanThreePosesWithTruthAreRefused) {
  EXPECT_FALSE(AlignHandEye(SmoothSeries(0, 2, 50), MarkerTruth(), {Alignment()}, Options()));
  EXPECT_FALSE(AlignHandEye(SmoothSeries(100, 50, 50), MarkerTruth(), {Alignment()}, Options()));
}

}  // namespace
}  // namespace tagtwist::internal::hand_eye_test
