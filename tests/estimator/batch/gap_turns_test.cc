// A body turns while no tag is in view: what a batch says of the gap and of the states beside it,
// by draws with exact truth.
#include "estimator/batch/gap_turns.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "estimator/batch/batch.h"
#include "estimator/batch/gaps.h"
#include "estimator/report/findings/findings.h"
#include "estimator/report/findings/verdict.h"
#include "frontend/types/nees.h"
#include "frontend/types/so3.h"
#include "tests/support/draws.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/tag_scene.h"
#include "tests/support/situations/situations.h"

namespace tagtwist::internal::gap_turns_test {
namespace {

constexpr double kDegree = 0.017453292519943295;

// Held by hand over the mat: sums of a few slow sines.
struct Hand {
  std::vector<Eigen::Vector4d> sines;  // of each axis: amplitude, rate, phase; three sines an axis

  static Hand Draw(double amplitude, std::mt19937_64* engine) {
    std::uniform_real_distribution<double> uniform(0, 1);
    Hand out;
    for (int i = 0; i < 9; ++i) {
      const Eigen::Vector3d drawn = DrawVector<3>(uniform, *engine);
      out.sines.emplace_back(amplitude * (0.5 + drawn.x()), 1 + 3 * drawn.y(), 6.28 * drawn.z(), 0);
    }
    return out;
  }
  Eigen::Vector3d At(double t_s) const {
    Eigen::Vector3d out = Eigen::Vector3d::Zero();
    for (size_t i = 0; i < sines.size(); ++i) {
      const Eigen::Vector4d& s = sines[i];
      out[static_cast<Eigen::Index>(i % 3)] += s[0] * std::sin(s[1] * t_s + s[2]);
    }
    return out;
  }
};

struct Recording {
  std::vector<BodyState> truth;
  std::vector<FrameMeasurements> measurements;
  double gap_s = 0;
};

// `turn_at`: about z, of the time since the gap began [s]. `beside_s`: on either side of the gap.
// `calm`: amplitudes of all but the turn.
Recording Record(double gap_s, unsigned seed, const std::function<double(double)>& turn_at,
                 double beside_s = 2, double calm = 1) {
  constexpr double kNoisePx = 0.2, kRateHz = 30;
  std::mt19937_64 engine(seed);
  const Hand place = Hand::Draw(0.04 * calm, &engine), attitude = Hand::Draw(0.03 * calm, &engine);
  const EstimatorSetup setup = CourseSetup();
  const auto pose_at = [&](double t_s) {
    return MakePose(ExpSo3({0, 0, turn_at(t_s - beside_s)}) * ExpSo3(attitude.At(t_s)),
                    Eigen::Vector3d(1.6, 1.4, 1.2) + place.At(t_s));
  };
  Recording out;
  out.gap_s = gap_s;
  const int n = static_cast<int>((beside_s + gap_s + beside_s) * kRateHz);
  for (int k = 0; k < n; ++k) {
    const double t_s = k / kRateHz;
    FrameMeasurements& m = out.measurements.emplace_back();
    m.t_ns = static_cast<int64_t>(std::llround(1e9 * t_s));
    out.truth.push_back(StateAlong(pose_at, t_s));
    if (t_s < beside_s || t_s > beside_s + gap_s) {
      m.tags = SeeTags(setup.map, setup.camera,
                       setup.cam_from_body * Inverse(out.truth.back().world_from_body), kNoisePx,
                       1000 * seed + static_cast<unsigned>(k));
      m.tags.resize(std::min<size_t>(m.tags.size(), 6));
    }
  }
  return out;
}

// Begun and ended within the gap.
Recording RecordTurn(double turn_rad, double gap_s, unsigned seed, double calm = 1) {
  const auto turn_at = [=](double t_s) {
    const double f = std::clamp((t_s / gap_s - 0.08) / 0.84, 0.0, 1.0);
    return turn_rad * f * f * (3 - 2 * f);
  };
  return Record(gap_s, seed, turn_at, 2, calm);
}

// At a constant rate all the time, by that angle in the gap.
Recording RecordSpin(double turn_rad, double gap_s, unsigned seed) {
  return Record(gap_s, seed, [=](double t_s) { return turn_rad * t_s / gap_s; });
}

Estimate Solve(const Recording& recording) {
  auto out = RunBatch(CourseSetUp(), {}, recording.measurements);
  EXPECT_TRUE(out) << (out ? "" : out.error().message);
  return out ? std::move(*out) : Estimate();
}

// Over many recordings.
struct Tally {
  double nees = 0, gap_nees = 0, rotation_rad = 0;  // per degree of freedom; the largest error
  int frames = 0, beyond = 0, in_gap = 0, ambiguous = 0;

  void Add(const Recording& recording, const Estimate& estimate) {
    ASSERT_EQ(estimate.frames.size(), recording.truth.size());
    for (size_t k = 0; k < estimate.frames.size(); ++k) {
      const FrameEstimate& frame = estimate.frames[k];
      const BodyState& truth = recording.truth[k];
      const auto of_all = Nees(truth, frame.state, frame.covariance, kWholeState);
      ASSERT_TRUE(of_all);
      nees += *of_all / 12;
      ++frames, beyond += IsBeyondFiveSigma(truth, frame) ? 1 : 0;
      rotation_rad = std::max(rotation_rad,
                              RotationErrorRad(frame.state.world_from_body, truth.world_from_body));
      if (frame.n_tags > 0) continue;
      ++in_gap, ambiguous += frame.status == FrameStatus::kAmbiguous ? 1 : 0;
      gap_nees += *of_all / 12;
    }
  }
  void ExpectHonest(const std::string& what) const {
    ASSERT_GT(frames, 0);
    EXPECT_GT(nees / frames, 0.5) << what;
    EXPECT_LT(nees / frames, 1.6) << what;
    EXPECT_LT(gap_nees / in_gap, 2.5) << what;
    EXPECT_LE(beyond, 0.01 * frames) << what;
  }
};

TEST(GapTurns, ASpinIsFollowedThroughAGap) {
  for (const double degrees : {-210.0, 360.0, 800.0}) {
    Tally tally;
    for (const double gap_s : {0.3, 0.9}) {
      const Recording spin = RecordSpin(degrees * kDegree, gap_s, 7);
      tally.Add(spin, Solve(spin));
    }
    tally.ExpectHonest(std::to_string(degrees));
    EXPECT_LT(tally.rotation_rad, 0.3) << degrees;
    EXPECT_EQ(tally.ambiguous, 0) << degrees;
  }
}

TEST(GapTurns, ATurnThatMayHaveBeenTheOtherWayHasBothInItsCovariance) {
  for (const double degrees : {150.0, -205.0}) {
    Tally tally;
    for (const double gap_s : {0.4, 2.4}) {
      const Recording turn = RecordTurn(degrees * kDegree, gap_s, 3);
      tally.Add(turn, Solve(turn));
    }
    tally.ExpectHonest(std::to_string(degrees));
    EXPECT_GT(tally.ambiguous, tally.in_gap / 2) << degrees;
  }
}

// From rest: the recording says that it turned by 60 degrees the other way.
TEST(GapTurns, MostOfAWholeTurnIsNotTakenForTheShortWayRound) {
  Tally tally;
  for (const double gap_s : {1.0, 2.0}) {
    const Recording turn = RecordTurn(300 * kDegree, gap_s, 4);
    tally.Add(turn, Solve(turn));
  }
  tally.ExpectHonest("300 degrees");
  EXPECT_GT(tally.ambiguous, tally.in_gap / 2);
}

// Of 120 such sets of draws NEES in gaps is 1.04 in the mean, 1.84 at most. Recordings of one
// draw, which differ in their turns alone, have much in common: up to 2.85.
TEST(GapTurns, AGapIsAsLivelyAsItsEndsSay) {
  Tally tally;
  unsigned seed = 1;
  for (const double degrees : {-25.0, 28.0}) {
    for (const double gap_s : {0.3, 0.6, 1.2}) {
      const Recording turn = RecordTurn(degrees * kDegree, gap_s, seed++, 0.1);
      tally.Add(turn, Solve(turn));
    }
  }
  tally.ExpectHonest("small turns");
  EXPECT_LT(tally.gap_nees, 1.9 * tally.in_gap);
  EXPECT_EQ(tally.ambiguous, 0);
}

TEST(GapTurns, ALongGapTakesTheDensityOfLongTimes) {
  Tally tally;
  for (const unsigned seed : {1, 2, 3}) {
    const auto no_turn = [](double) { return 0.0; };
    const Recording still = Record(4, seed, no_turn, 6);
    tally.Add(still, Solve(still));
  }
  tally.ExpectHonest("no turn");
}

TEST(GapTurns, TheVerdictSaysSo) {
  const Recording turn = RecordTurn(3.0, 1, 3);
  const Estimate estimate = Solve(turn);
  const auto findings = Findings(estimate, {}, CourseSetUp().map, {});
  const std::string verdict = VerdictText(estimate, findings, {});
  EXPECT_NE(verdict.find("not to be relied on"), std::string::npos) << verdict;
  EXPECT_NE(verdict.find("which way the body turned"), std::string::npos) << verdict;
}

const NoiseModel kCalm{0.2, 0.3, {WhiteNoiseOn::kJerk, 1}, {WhiteNoiseOn::kJerk, 1}};

// Frames of a camera that turned by that vector while it saw nothing, five on either side.
GraphInput TurnedFrames(const Eigen::Vector3d& turn, const Eigen::Vector3d& rate) {
  GraphInput out;
  for (int k = 0; k < 10; ++k) {
    GraphFrame frame;
    const double t_s = 0.03 * k + (k < 5 ? 0 : 1);
    frame.t_ns = static_cast<int64_t>(std::llround(1e9 * t_s));
    frame.state.world_from_body =
        MakePose((k < 5 ? Eigen::Quaterniond::Identity() : ExpSo3(turn)) * ExpSo3(0.03 * k * rate),
                 Eigen::Vector3d(0.01 * k, 0, 0));
    out.frames.push_back(std::move(frame));
  }
  return out;
}

TEST(Gaps, ASmallTurnNeedsNoBridge) {
  GraphInput input = TurnedFrames({0, 0, 0.5}, Eigen::Vector3d::Zero());
  std::vector<int> states = {0, 1, 2, 3, 4, -1, 5, 6, 7, 8, 9};
  const std::vector<int> before = states;
  const auto gaps = FindAndBridgeGaps(kCalm, &states, &input);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_FALSE(IsBridged(gaps.front()));
  EXPECT_EQ(states, before);
  EXPECT_EQ(input.frames.size(), 10u);
}

TEST(Gaps, BridgesTurnAsTheRatesSayAndAllIsCountedAnew) {
  for (const double rate : {-6.0, 0.0, 6.0, 13.0}) {
    GraphInput input = TurnedFrames({0, 0, 2}, {0, 0, rate});
    TrackSegment segment;
    segment.first_frame = 6;
    segment.pixels.resize(3);
    input.segments.push_back(segment);
    std::vector<int> states = {0, 1, 2, 3, 4, -1, 5, 6, 7, 8, 9};
    const auto gaps = FindAndBridgeGaps(kCalm, &states, &input);
    ASSERT_EQ(gaps.size(), 1u);
    ASSERT_TRUE(IsBridged(gaps.front()));
    const int bridges = static_cast<int>(input.frames.size()) - 10;
    EXPECT_EQ(gaps.front().first, 4);
    EXPECT_EQ(gaps.front().last, 5 + bridges);
    EXPECT_EQ(states[4], 4);
    EXPECT_EQ(states[5], -1);
    EXPECT_EQ(states[6], 5 + bridges);
    EXPECT_EQ(input.segments.front().first_frame, 6 + bridges);
    const GapTurn turn = TurnThrough(input.frames, gaps.front());
    // Of all turns that end there the nearest to what the rate makes of 1.03 s.
    EXPECT_LT(std::abs((turn.whole + turn.rest).z() - 1.03 * rate), 3.15) << rate;
    for (size_t k = 1; k < input.frames.size(); ++k) {
      EXPECT_GT(input.frames[k].t_ns, input.frames[k - 1].t_ns);
      EXPECT_LT(AngleBetween(input.frames[k].state.world_from_body,
                             input.frames[k - 1].state.world_from_body),
                0.81);
    }
    const GapTurn other = TurnedOn(input.frames, gaps.front(), turn, 1);
    LayBridges(other, gaps.front(), &input.frames);
    const GapTurn laid = TurnThrough(input.frames, gaps.front());
    EXPECT_NEAR((laid.whole - turn.whole).norm(), 6.2832, 1e-3);
    EXPECT_NEAR((laid.rest - turn.rest).norm(), 0, 1e-9);
  }
}

TEST(Gaps, WhereTheMotionMayTurnItFarAnyGapIsBridged) {
  NoiseModel lively = kCalm;
  lively.angular.psd = 1000;
  GraphInput input = TurnedFrames({0, 0, 0.1}, Eigen::Vector3d::Zero());
  std::vector<int> states = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  const auto gaps = FindAndBridgeGaps(lively, &states, &input);
  ASSERT_EQ(gaps.size(), 1u);
  EXPECT_TRUE(IsBridged(gaps.front()));
}

TEST(Gaps, WhatATrackTiesIsNone) {
  GraphInput input = TurnedFrames({0, 0, 2}, Eigen::Vector3d::Zero());
  TrackSegment segment;
  segment.first_frame = 4;
  segment.pixels.resize(2);
  input.segments.push_back(segment);
  std::vector<int> states = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_TRUE(FindAndBridgeGaps(kCalm, &states, &input).empty());
  EXPECT_EQ(input.frames.size(), 10u);
}

}  // namespace
}  // namespace tagtwist::internal::gap_turns_test
