#include "estimator/start/steady_clock.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <utility>

#include "estimator/batch/batch.h"
#include "estimator/window/sliding_window.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::steady_clock_test {
namespace {

// Ticks at 50 Hz, stamped late and early by up to `jitter_s` (uniform); those in `lost` are
// missing.
struct Stamped {
  std::vector<int64_t> ticks, stamps;
};
Stamped Stamp(int size, double jitter_s, const std::vector<int>& lost, unsigned seed) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  Stamped out;
  for (int i = 0; i < size; ++i) {
    const double jitter = jitter_s * uniform(rng);
    if (std::find(lost.begin(), lost.end(), i) != lost.end()) continue;
    out.ticks.push_back(1'000'000'000LL + i * 20'000'000LL);
    out.stamps.push_back(out.ticks.back() + static_cast<int64_t>(1e9 * jitter));
  }
  return out;
}

TEST(SteadyClock, FindsTheTicksUnderJitterAndLostFrames) {
  for (const std::vector<int>& lost : {std::vector<int>{}, {7, 50, 51, 52, 200}}) {
    const Stamped s = Stamp(400, 0.006, lost, 3);
    const auto clock = FitSteadyClock(s.stamps);
    ASSERT_TRUE(clock);
    EXPECT_NEAR(clock->period_s, 0.02, 5e-6);
    EXPECT_NEAR(clock->rms_s, 0.006 / std::sqrt(3.0), 3e-4);
    double chi2 = 0;
    for (size_t i = 0; i < s.ticks.size(); ++i) {
      const double e = 1e-9 * static_cast<double>(clock->t_ns[i] - s.ticks[i]);
      EXPECT_LT(std::abs(e), 8e-4) << i;
      chi2 += e * e / (clock->sigma_s[i] * clock->sigma_s[i]) / static_cast<double>(s.ticks.size());
    }
    EXPECT_LT(chi2, 6.0);
  }
}

// A host that is busy now and then stamps a frame late, up to two periods and more; the others tell
// the clock, and it is no frame that was lost.
TEST(SteadyClock, PassesOverStampsThatCameLate) {
  for (const std::vector<int>& lost : {std::vector<int>{}, {50, 51, 200}}) {
    Stamped s = Stamp(400, 1e-5, lost, 3);
    std::mt19937 rng(5);
    std::exponential_distribution<double> late_s(1 / 0.008);
    int64_t last_ns = 0;
    for (size_t i = 0; i < s.stamps.size(); ++i) {
      if (rng() % 10 == 0) s.stamps[i] += static_cast<int64_t>(1e9 * late_s(rng));
      last_ns = s.stamps[i] = std::max(s.stamps[i], last_ns + 100'000);
    }
    const auto clock = FitSteadyClock(s.stamps);
    ASSERT_TRUE(clock);
    EXPECT_GT(clock->rms_s, 2e-3);  // of all
    // Whether the last one is late, or frames were lost before it, nobody knows.
    for (size_t i = 0; i + 1 < s.ticks.size(); ++i) {
      const double e = 1e-9 * static_cast<double>(clock->t_ns[i] - s.ticks[i]);
      EXPECT_LT(std::abs(e), 2e-5) << i;
      EXPECT_LT(clock->sigma_s[i], 1e-5);
    }
  }
}

// A host that takes two frames at a time stamps them half a millisecond apart.
TEST(SteadyClock, SeesThroughPairs) {
  std::vector<int64_t> stamps;
  for (int i = 0; i < 200; ++i) {
    const int64_t at_host = 40'000'000LL * (i / 2 + 1);
    stamps.push_back(at_host + 500'000LL * (i % 2));
  }
  const auto clock = FitSteadyClock(stamps);
  ASSERT_TRUE(clock);
  EXPECT_NEAR(clock->period_s, 0.02, 1e-5);
}

// And one that takes three, four or five.
TEST(SteadyClock, SeesThroughLongerBursts) {
  std::mt19937_64 rng(5);
  std::uniform_real_distribution<double> late_s(0, 1e-3);
  for (const int at_a_time : {3, 4, 5}) {
    std::vector<int64_t> stamps;
    double at_host_s = 0;
    for (int i = 0; i < 60 * at_a_time; ++i) {
      if (i % at_a_time == 0) at_host_s = 0.02 * (i + at_a_time) + late_s(rng);
      stamps.push_back(static_cast<int64_t>(1e9 * (at_host_s + 2e-4 * (i % at_a_time))));
    }
    const auto clock = FitSteadyClock(stamps);
    ASSERT_TRUE(clock) << at_a_time;
    EXPECT_NEAR(clock->period_s, 0.02, 2e-5) << at_a_time;
  }
}

TEST(SteadyClock, LeavesStampsWithoutOneAlone) {
  EXPECT_FALSE(FitSteadyClock({}));
  EXPECT_FALSE(FitSteadyClock({1, 2, 3}));
  std::mt19937_64 rng(1);
  std::exponential_distribution<double> gap(50.0);
  std::vector<int64_t> stamps = {0};
  for (int i = 0; i < 300; ++i) {
    stamps.push_back(stamps.back() + 1'000'000 + static_cast<int64_t>(1e9 * gap(rng)));
  }
  EXPECT_FALSE(FitSteadyClock(stamps));
}

double VelocityRmse(const std::vector<FrameEstimate>& frames, const std::vector<BodyState>& truth) {
  double sum = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    sum += Difference(frames[i].state, truth[i]).segment<3>(6).squaredNorm();
  }
  return std::sqrt(sum / static_cast<double>(frames.size()));
}

ExactModelFlight FastFlight() {
  ExactModelOptions model;
  model.frames = 120;
  model.random_seed = 2;
  model.corner_sigma_px = 0.05;  // so that the clock is what limits
  return DrawFlight(model);
}

// Images taken at steady ticks and stamped by a busy computer.
TEST(BatchClock, AJitteredClockIsSeenAndSteadied) {
  const ExactModelFlight flight = FastFlight();
  std::vector<FrameMeasurements> jittered = flight.measurements;
  const Stamped s = Stamp(120, 0.006, {}, 4);
  std::vector<int64_t> stamps;
  for (size_t i = 0; i < jittered.size(); ++i) {
    jittered[i].t_ns += s.stamps[i] - s.ticks[i];
    stamps.push_back(jittered[i].t_ns);
  }
  EstimatorOptions as_stamped;
  as_stamped.clock = ClockChoice::kStamps;
  const auto plain = RunBatch(CourseSetUp(), as_stamped, jittered);
  const auto steadied = RunBatch(CourseSetUp(), {}, jittered);
  ASSERT_TRUE(plain);
  ASSERT_TRUE(steadied);
  ASSERT_EQ(steadied->warnings.size(), 1u);
  EXPECT_NE(steadied->warnings[0].find("clock is steady at"), std::string::npos)
      << steadied->warnings[0];
  // A row has its frame's stamp, and the state of when that was taken.
  const std::vector<FrameEstimate>& at_ticks = steadied->frames;
  ASSERT_EQ(at_ticks.size(), stamps.size());
  for (size_t i = 0; i < stamps.size(); ++i) ASSERT_EQ(at_ticks[i].t_ns, stamps[i]);
  std::vector<FrameEstimate> plain_at_ticks;
  for (const FrameMeasurements& m : flight.measurements) {
    FrameEstimate e;
    e.state = plain->trajectory.At(m.t_ns)->state;
    plain_at_ticks.push_back(e);
  }
  EXPECT_LT(VelocityRmse(at_ticks, flight.truth), 0.5 * VelocityRmse(plain_at_ticks, flight.truth));
}

// Frames at no steady rate, stamped up to 1 ms early or late.
struct Roughly {
  std::vector<FrameMeasurements> measurements;
  std::vector<BodyState> truth;  // at the stamps
};
Roughly StampRoughly(double half_step_s) {
  ExactModelOptions model;
  model.frames = 60;  // then it leaves the mat
  model.linear = {WhiteNoiseOn::kJerk, 5};
  model.corner_sigma_px = 0.05;
  const ExactModelFlight flight = DrawFlight(model);
  std::mt19937_64 rng(7);
  std::uniform_real_distribution<double> off_s(-half_step_s, half_step_s);
  Roughly out;
  for (size_t i = 0; i < flight.measurements.size(); ++i) {
    if (i % 7 == 1 || i % 5 == 2) continue;
    const double late_s = off_s(rng);
    out.measurements.push_back(flight.measurements[i]);
    out.measurements.back().t_ns += std::llround(1e9 * late_s);
    BodyState state = flight.truth[i];
    const Pose& pose = state.world_from_body;
    state.world_from_body =
        MakePose(pose.rotation(), pose.translation() + late_s * state.twist.v_world);
    out.truth.push_back(state);
  }
  return out;
}

// Of positions, a degree of freedom; `frames` are the first of the truth's.
double PositionNees(const std::vector<FrameEstimate>& frames, const std::vector<BodyState>& truth) {
  double sum = 0;
  for (size_t i = 0; i < frames.size(); ++i) {
    const Eigen::Vector3d off = Difference(frames[i].state, truth[i]).segment<3>(3);
    const Eigen::Matrix3d covariance = frames[i].covariance.block<3, 3>(3, 3);
    sum += off.dot(covariance.ldlt().solve(off)) / 3;
  }
  return sum / static_cast<double>(frames.size());
}

TEST(StampError, ThatNoClockMendsIsInTheCovariance) {
  const Roughly rough = StampRoughly(0.001);
  EstimatorOptions options;
  options.clock = ClockChoice::kStamps;
  for (const bool is_known : {false, true}) {
    if (is_known) options.stamp_sigma_s = 0.002 / std::sqrt(12.0);
    const auto batch = RunBatch(CourseSetUp(), options, rough.measurements);
    ASSERT_TRUE(batch);
    SlidingWindow window(CourseSetUp(), options);
    std::vector<FrameEstimate> newest, lagged;
    for (const FrameMeasurements& measurement : rough.measurements) {
      auto output = window.Add(measurement);
      ASSERT_TRUE(output);
      newest.push_back(output->current);
      lagged.insert(lagged.end(), output->lagged.begin(), output->lagged.end());
    }
    const std::vector<FrameEstimate> last = window.Finish();
    lagged.insert(lagged.end(), last.begin(), last.end());
    for (const std::vector<FrameEstimate>* frames :
         {&batch->frames, &std::as_const(newest), &std::as_const(lagged)}) {
      const double nees = PositionNees(*frames, rough.truth);
      if (is_known) {
        EXPECT_GT(nees, 0.4);
        EXPECT_LT(nees, 1.5);
      } else {
        EXPECT_GT(nees, 3);
      }
    }
  }
}

TEST(BatchClock, TrueUnevenStampsAreKept) {
  ExactModelFlight flight = FastFlight();
  std::vector<FrameMeasurements> uneven;
  for (size_t i = 0; i < flight.measurements.size(); ++i) {
    if (i % 3 != 1) uneven.push_back(flight.measurements[i]);  // intervals of 20 and 40 ms
  }
  const auto result = RunBatch(CourseSetUp(), {}, uneven);
  ASSERT_TRUE(result);
  EXPECT_TRUE(result->warnings.empty());
}

}  // namespace
}  // namespace tagtwist::internal::steady_clock_test
