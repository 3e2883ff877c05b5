#include "estimator/result/run_tally.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "frontend/base/statistics/thinned_sample.h"
#include "tests/support/flights/synthetic_estimate.h"

namespace tagtwist::internal::run_tally_test {
namespace {

TEST(StretchTally, TellsTheLongestInOrderOfTimeWhateverComesAfter) {
  StretchTally tally;
  double t_s = 0;
  const auto add = [&](int frames) {
    for (int i = 0; i < frames; ++i) tally.Add(t_s++, true);
    tally.Add(t_s++, false);
  };
  for (const int frames : {2, 5, 1, 3, 2, 4}) add(frames);
  EXPECT_EQ(tally.count(), 17U);
  EXPECT_EQ(tally.Text(), "3.00 to 7.00 s, 11.00 to 13.00 s, 18.00 to 21.00 s and 3 other times");
  tally.Add(t_s, true);
  tally.Add(t_s + 1, true);
  EXPECT_EQ(tally.Text(), "3.00 to 7.00 s, 11.00 to 13.00 s, 18.00 to 21.00 s and 4 other times");
}

TEST(StepTally, FindsGapsOfMoreStepsThanItHolds) {
  StepTally tally;
  double t_s = 0;
  const auto step = [&](double s) {
    tally.Add(t_s, s);
    t_s += s;
  };
  for (int i = 0; i < 20'000; ++i) step(i % 2 == 0 ? 0.019 : 0.021);
  step(0.2);
  for (int i = 0; i < 100; ++i) step(0.02);
  const auto found = tally.Get();
  ASSERT_TRUE(found);
  EXPECT_EQ(found->gaps, 1U);
  EXPECT_NEAR(found->missing, 9, 1);
  EXPECT_NEAR(found->longest_from_s, 400, 1e-6);
  EXPECT_NEAR(found->mean_s, 0.02, 1e-6);
  EXPECT_NEAR(found->mean_square_s2, 1e-6, 1e-8);
  EXPECT_FALSE(StepTally().Get());
}

TEST(FrameTally, CountsWhatFramesAre) {
  const Estimate estimate = SyntheticEstimate(60, true);
  const FrameTally tally = TallyOf(estimate).frames;
  EXPECT_EQ(tally.frames, 60U);
  EXPECT_EQ(tally.with_state, 58U);
  EXPECT_EQ(tally.count(FrameStatus::kNoFix), 2U);
  EXPECT_EQ(tally.before_first_tag, 2U);
  EXPECT_EQ(tally.estimated.frames, 58U);
  EXPECT_EQ(tally.without_state.count(), 2U);
  double changes = 0;
  for (size_t i = 3; i < estimate.frames.size(); ++i) {
    const Twist &a = estimate.frames[i - 1].state.twist, &b = estimate.frames[i].state.twist;
    changes += (b.v_world - a.v_world).squaredNorm();
  }
  EXPECT_NEAR(tally.velocity_changes, changes, 1e-9 * changes);
}

// A body that is told to stand, and tags that say it turns at that rate from the tenth frame on.
size_t UnheardFrames(double rate_radps, double sigma_rad, FrameStatus status, int every = 1) {
  UnheardTags tally;
  for (int k = 0; k < 60; ++k) {
    const double t_s = k / 60.0;
    FrameEstimate frame;
    frame.status = k < 10 ? FrameStatus::kOk : status;
    frame.n_tags = k < 10 ? 1 : 0;
    frame.covariance.diagonal().setConstant(sigma_rad * sigma_rad);
    if (k % every == 0) {
      const double angle_rad = rate_radps * std::max(0.0, t_s - 10 / 60.0);
      frame.closed_form.world_from_body =
          MakePose(Eigen::Quaterniond(Eigen::AngleAxisd(angle_rad, Eigen::Vector3d::UnitZ())),
                   Eigen::Vector3d::Zero());
    }
    tally.Add(t_s, frame);
  }
  return tally.where.count();
}

TEST(UnheardTags, AreFramesInARowThatSayAnotherPoseThanTheEstimate) {
  EXPECT_GT(UnheardFrames(3, 0.01, FrameStatus::kPredicted), 30U);
  EXPECT_EQ(UnheardFrames(0, 0.01, FrameStatus::kPredicted), 0U);    // they say the same
  EXPECT_EQ(UnheardFrames(3, 1, FrameStatus::kPredicted), 0U);       // it claims to know nothing
  EXPECT_EQ(UnheardFrames(3, 0.01, FrameStatus::kNoFix), 0U);        // it claims nothing
  EXPECT_EQ(UnheardFrames(300, 0.01, FrameStatus::kPredicted), 0U);  // no way of a body
  EXPECT_GT(UnheardFrames(3, 0.01, FrameStatus::kPredicted, 2), 10U);
}

TEST(ThinnedSample, ThoseOfEquallyManyHaveTheSamePlaces) {
  ThinnedSample<int> a(32), b(32);
  for (int i = 0; i < 1000; ++i) a.Add(i);
  for (int i = 0; i < 1000; ++i) b.Add(7 * i);
  ASSERT_EQ(a.values().size(), b.values().size());
  for (size_t i = 0; i < a.values().size(); ++i) EXPECT_EQ(7 * a.values()[i], b.values()[i]);
}

}  // namespace
}  // namespace tagtwist::internal::run_tally_test
