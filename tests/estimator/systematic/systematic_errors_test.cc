// Errors of lens, map and corners that last over a recording: found where they are, covered by the
// covariances, and not found where there are none.
#include "estimator/systematic/systematic_errors.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <array>
#include <cmath>
#include <random>

#include "estimator/batch/batch.h"
#include "estimator/window/sliding_window.h"
#include "frontend/types/rig.h"
#include "tests/support/draws.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/simulated_flight.h"

namespace tagtwist::internal::systematic_errors_test {
namespace {

using testing::AllOf;
using testing::Gt;
using testing::Lt;

// What is wrong with a drawn set-up: standard deviations.
struct Faults {
  double field_px = 0, tag_m = 0, bias_px = 0;
};

// Smooth over the image: a few waves of drawn direction and phase.
class DrawnField {
 public:
  DrawnField(double sigma_px, std::mt19937* random) {
    std::normal_distribution<double> normal;
    std::uniform_real_distribution<double> phase(0, 2 * M_PI);
    for (Wave& wave : waves_) {
      wave.along = DrawVector<2>(normal, *random) / 130;
      wave.phase = phase(*random);
      wave.size = sigma_px / std::sqrt(static_cast<double>(waves_.size()) / 2) *
                  DrawVector<2>(normal, *random);
    }
  }
  Eigen::Vector2d At(const Eigen::Vector2d& pixel) const {
    Eigen::Vector2d out = Eigen::Vector2d::Zero();
    for (const Wave& w : waves_) out += w.size * std::cos(w.along.dot(pixel) + w.phase);
    return out;
  }

 private:
  struct Wave {
    Eigen::Vector2d along, size;
    double phase = 0;
  };
  std::array<Wave, 8> waves_;
};

struct Drawn {
  SetUp set_up;  // as believed
  SimulatedFlight flight;
};

Drawn Draw(const std::string& name, const Faults& faults, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  Drawn out{CourseSetUp(), SimulateCorners(name, 8, 30)};
  const DrawnField field(faults.field_px, &random);
  const double bias_px = faults.bias_px * normal(random);
  for (FrameMeasurements& frame : out.flight.measurements) {
    for (TagDetection& tag : frame.tags) {
      const Eigen::Vector2d centre =
          (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]) / 4;
      for (Eigen::Vector2d& corner : tag.corners) {
        corner += field.At(corner) + bias_px * (corner - centre).normalized();
      }
    }
  }
  std::vector<Tag> tags = out.set_up.map.tags();
  for (Tag& tag : tags) {
    for (int a = 4; a < 7; ++a) tag.world_from_tag.params(a) += faults.tag_m * normal(random);
  }
  out.set_up.map = TagMap(out.set_up.map.family(), tags);
  return out;
}

Estimate Solve(const Drawn& drawn, bool systematic = true) {
  EstimatorOptions options;
  options.systematic_errors = systematic;
  auto estimate = RunBatch(drawn.set_up, options, drawn.flight.measurements);
  EXPECT_TRUE(estimate);
  return std::move(*estimate);
}

// Per degree of freedom, over all frames.
double PoseNees(const Estimate& estimate, const std::vector<BodyState>& truth) {
  double sum = 0;
  for (size_t i = 0; i < truth.size(); ++i) {
    const FrameEstimate& frame = estimate.frames[i];
    const Eigen::Matrix<double, 6, 1> error =
        Difference(truth[i].world_from_body, frame.state.world_from_body);
    const PoseCovariance covariance = frame.covariance.topLeftCorner<6, 6>();
    sum += error.dot(covariance.inverse() * error) / 6;
  }
  return sum / static_cast<double>(truth.size());
}

TEST(SystematicErrors, SlowAreNotFoundWhereThereAreNone) {
  for (const char* name : {"figure8", "agile", "hover", "circle"}) {
    const Estimate estimate = Solve(Draw(name, {}, 1));
    EXPECT_EQ(estimate.systematic.position_m, 0) << name;
    EXPECT_EQ(estimate.systematic.field_sigma_px, 0) << name;
    EXPECT_EQ(estimate.systematic.tag_sigma_m, 0) << name;
    EXPECT_EQ(estimate.systematic.bias_sigma_px, 0) << name;
  }
}

TEST(SystematicErrors, OfEachKindAreFoundAsWhatTheyAre) {
  const SystematicShare of_lens = Solve(Draw("figure8", {0.3, 0, 0}, 2)).systematic;
  EXPECT_THAT(of_lens.field_sigma_px, AllOf(Gt(0.15), Lt(0.6)));
  EXPECT_LT(of_lens.tag_sigma_m, 0.3e-3);
  const SystematicShare of_map = Solve(Draw("figure8", {0, 2e-3, 0}, 3)).systematic;
  EXPECT_THAT(of_map.tag_sigma_m, AllOf(Gt(1.5e-3), Lt(2.5e-3)));
  EXPECT_LT(of_map.field_sigma_px, 0.1);
}

// All at once, drawn anew: the covariances hold, and they do not without.
TEST(SystematicErrors, SlowAreCoveredByTheCovariances) {
  double with = 0, without = 0;
  int runs = 0;
  for (const char* name : {"figure8", "agile", "circle", "hover"}) {
    for (unsigned seed = 10; seed < 13; ++seed, ++runs) {
      const Drawn drawn = Draw(name, {0.3, 2e-3, 0.2}, seed);
      with += PoseNees(Solve(drawn), drawn.flight.truth);
      without += PoseNees(Solve(drawn, false), drawn.flight.truth);
    }
  }
  EXPECT_THAT(with / runs, AllOf(Gt(0.5), Lt(2)));
  EXPECT_GT(without / runs, 8);
}

// What a window says of a flight, at arrival and at the lag, but for its first second.
struct WindowNees {
  double current = 0, lagged = 0;
};

WindowNees NeesOfWindow(const Drawn& drawn, const EstimatorOptions& options) {
  SlidingWindow window(drawn.set_up, options);
  Estimate current, lagged;
  for (const FrameMeasurements& measurement : drawn.flight.measurements) {
    auto out = window.Add(measurement);
    EXPECT_TRUE(out);
    current.frames.push_back(out->current);
    lagged.frames.insert(lagged.frames.end(), out->lagged.begin(), out->lagged.end());
  }
  for (const FrameEstimate& frame : window.Finish()) lagged.frames.push_back(frame);
  EXPECT_EQ(lagged.frames.size(), current.frames.size());
  const std::vector<BodyState> truth(drawn.flight.truth.begin() + 30, drawn.flight.truth.end());
  for (Estimate* e : {&current, &lagged})
    e->frames.erase(e->frames.begin(), e->frames.begin() + 30);
  return {PoseNees(current, truth), PoseNees(lagged, truth)};
}

// Given, or as the window learns them itself; it does not hold without.
TEST(SystematicErrors, SlowAreInTheWindowsCovariances) {
  EstimatorOptions given, without;
  given.lens_field_sigma_px = 0.3;
  given.tag_sigma_m = 2e-3;
  given.corner_bias_sigma_px = 0.2;
  without.systematic_errors = false;
  const std::array<EstimatorOptions, 3> ways = {given, EstimatorOptions(), without};
  std::array<WindowNees, 3> mean;
  constexpr unsigned kRuns = 12;
  for (const char* name : {"figure8", "agile", "circle", "hover"}) {
    for (unsigned seed = 10; seed < 13; ++seed) {
      const Drawn drawn = Draw(name, {0.3, 2e-3, 0.2}, seed);
      for (size_t i = 0; i < ways.size(); ++i) {
        const WindowNees own = NeesOfWindow(drawn, ways[i]);
        mean[i].current += own.current / kRuns, mean[i].lagged += own.lagged / kRuns;
      }
    }
  }
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_THAT(mean[i].current, AllOf(Gt(0.4), Lt(2))) << i;
    EXPECT_THAT(mean[i].lagged, AllOf(Gt(0.4), Lt(2))) << i;
  }
  EXPECT_GT(mean[2].lagged, 5);
}

TEST(SystematicErrors, AWindowOfAFlightWithoutAnyIsTheSame) {
  const Drawn drawn = Draw("figure8", {}, 4);
  EstimatorOptions without;
  without.systematic_errors = false;
  const WindowNees a = NeesOfWindow(drawn, {}), b = NeesOfWindow(drawn, without);
  EXPECT_EQ(a.current, b.current);
  EXPECT_EQ(a.lagged, b.lagged);
}

// From one height no residual shows a focal length that is off.
TEST(SystematicErrors, AGivenFocalSigmaCoversWhatNothingShows) {
  Drawn drawn{CourseSetUp(), SimulateCorners("figure8", 4, 30)};
  Camera& camera = drawn.set_up.rig.front().camera;
  camera.fx *= 1.02;
  camera.fy *= 1.02;
  EstimatorOptions given;
  given.focal_sigma = 0.02;
  EXPECT_GT(PoseNees(Solve(drawn), drawn.flight.truth), 100);
  const auto batch = RunBatch(drawn.set_up, given, drawn.flight.measurements);
  ASSERT_TRUE(batch);
  EXPECT_THAT(PoseNees(*batch, drawn.flight.truth), AllOf(Gt(0.1), Lt(2)));
  const WindowNees window = NeesOfWindow(drawn, given);
  EXPECT_THAT(window.current, AllOf(Gt(0.1), Lt(2)));
  EXPECT_THAT(window.lagged, AllOf(Gt(0.1), Lt(2)));
}

// Focal length and map off by draws of what is said of them.
TEST(SystematicErrors, SlowGivenSigmasOfLensAndMapHoldOverDraws) {
  EstimatorOptions given;
  given.focal_sigma = 0.02;
  given.tag_sigma_m = 2e-3;
  double batch = 0;
  WindowNees window;
  int runs = 0;
  for (const char* name : {"figure8", "agile", "circle"}) {
    for (unsigned seed = 20; seed < 24; ++seed, ++runs) {
      Drawn drawn = Draw(name, {0, 2e-3, 0}, seed);
      std::mt19937 random(seed);
      const double factor = 1 + 0.02 * std::normal_distribution<double>()(random);
      Camera& camera = drawn.set_up.rig.front().camera;
      camera.fx *= factor;
      camera.fy *= factor;
      const auto estimate = RunBatch(drawn.set_up, given, drawn.flight.measurements);
      ASSERT_TRUE(estimate);
      batch += PoseNees(*estimate, drawn.flight.truth);
      const WindowNees of_run = NeesOfWindow(drawn, given);
      window.current += of_run.current, window.lagged += of_run.lagged;
    }
  }
  EXPECT_THAT(batch / runs, AllOf(Gt(0.5), Lt(2)));
  EXPECT_THAT(window.current / runs, AllOf(Gt(0.5), Lt(2)));
  EXPECT_THAT(window.lagged / runs, AllOf(Gt(0.5), Lt(2)));
  RecordProperty("batch", std::to_string(batch / runs));
  RecordProperty("current", std::to_string(window.current / runs));
  RecordProperty("lagged", std::to_string(window.lagged / runs));
}

// A map may be farther off than its sigma says: the residuals show it.
TEST(SystematicErrors, SlowAGivenTagSigmaIsTheLeastThatABatchTakes) {
  const Drawn drawn = Draw("figure8", {0, 3e-3, 0}, 3);
  const auto sigma_m = [&](double given_m) {
    EstimatorOptions options;
    options.tag_sigma_m = given_m;
    const auto estimate = RunBatch(drawn.set_up, options, drawn.flight.measurements);
    EXPECT_TRUE(estimate);
    return estimate->systematic.tag_sigma_m;
  };
  EXPECT_THAT(sigma_m(1e-4), AllOf(Gt(2e-3), Lt(4e-3)));
  EXPECT_DOUBLE_EQ(sigma_m(1e-2), 1e-2);
  EXPECT_EQ(sigma_m(0), 0);
}

TEST(SystematicErrors, WidenTheCovarianceAndLeaveTheStatesAlone) {
  const Drawn drawn = Draw("figure8", {0.3, 2e-3, 0.2}, 4);
  const Estimate with = Solve(drawn), without = Solve(drawn, false);
  ASSERT_EQ(with.frames.size(), without.frames.size());
  for (size_t i = 0; i < with.frames.size(); ++i) {
    EXPECT_EQ(with.frames[i].state.world_from_body.params,
              without.frames[i].state.world_from_body.params);
    const StateCovariance added = with.frames[i].covariance - without.frames[i].covariance;
    EXPECT_GT(added.diagonal().minCoeff(), 0);
  }
  // Between the frames, too: the trajectory's own covariance has it.
  const int64_t between = (with.frames[50].t_ns + with.frames[51].t_ns) / 2;
  EXPECT_GT(with.trajectory.At(between)->covariance(3, 3),
            4 * without.trajectory.At(between)->covariance(3, 3));
}

}  // namespace
}  // namespace tagtwist::internal::systematic_errors_test
