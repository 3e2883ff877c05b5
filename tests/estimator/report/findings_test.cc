#include "estimator/report/findings/findings.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/report/findings/verdict.h"
#include "tests/support/flights/calibration_flight.h"

namespace tagtwist::internal::findings_test {
namespace {

using testing::HasSubstr;
using testing::Not;

// A flight by a set-up that is exactly as configured.
CalibrationFlight FlightAsConfigured(unsigned seed = 1, int frames = 250) {
  CalibrationFlightOptions options;
  options.errors = false;
  options.tag_position_sigma_m = options.tag_rotation_sigma_rad = 0;
  options.truth_position_sigma_m = options.truth_rotation_sigma_rad = 0;
  options.frames = frames;
  options.random_seed = seed;
  return DrawCalibrationFlight(options);
}

Estimate EstimateOf(const CalibrationFlight& flight) {
  const Config& c = flight.config;
  auto out = RunBatch(c.set_up, c.estimator, flight.measurements);
  EXPECT_TRUE(out) << out.error().message;
  return out ? std::move(*out) : Estimate();
}

std::string TextOf(const std::vector<Finding>& findings) {
  std::string out;
  for (const Finding& finding : findings) out += finding.fact + "\n";
  return out;
}

std::string FindingsOf(const CalibrationFlight& flight) {
  return TextOf(Findings(EstimateOf(flight), {}, flight.config.set_up.map, flight.ground_truth));
}

// The first flight and its estimate: what a test changes is a copy.
struct Case {
  CalibrationFlight flight = FlightAsConfigured();
  Estimate estimate = EstimateOf(flight);
  std::string Text() const {
    return TextOf(Findings(estimate, {}, flight.config.set_up.map, flight.ground_truth));
  }
};

Case RunAsConfigured() {
  static const Case* const run = new Case();
  return *run;
}

TEST(Findings, ASetUpAsConfiguredIsNotAccused) {
  EXPECT_EQ(RunAsConfigured().Text(), "");
  EXPECT_EQ(FindingsOf(FlightAsConfigured(2)), "");
}

TEST(Findings, NamesTheLens) {
  CalibrationFlight flight = FlightAsConfigured();
  flight.config.set_up.rig.front().camera.k1 = 0.03;
  EXPECT_THAT(FindingsOf(flight), HasSubstr("the lens calibration is off"));
}

TEST(Findings, NamesATagThatMovedTooLittleToBeLeftOut) {
  CalibrationFlight flight = FlightAsConfigured(1, 400);
  std::vector<Tag> tags = flight.config.set_up.map.tags();
  const size_t moved = tags.size() / 2 + 1;
  Pose& place = tags[moved].world_from_tag;
  place = MakePose(place.rotation(), place.translation() + Eigen::Vector3d(0.0012, 0, 0));
  flight.config.set_up.map = TagMap(flight.config.set_up.map.family(), tags);
  const std::string text = FindingsOf(flight);
  EXPECT_THAT(text, HasSubstr("Tag " + std::to_string(tags[moved].id) +
                              " has moved or is mapped wrongly: it lies 1."));
  EXPECT_THAT(text, Not(HasSubstr("lens")));
}

std::string VerdictOf(const Estimate& estimate, const Case& run,
                      const std::vector<Finding>& findings) {
  return VerdictText(estimate, findings, run.flight.ground_truth);
}

TEST(Verdict, TrustsWhatNothingSpeaksAgainst) {
  const Case run = RunAsConfigured();
  EXPECT_EQ(VerdictOf(run.estimate, run, {}),
            "to be relied on within its sigmas: nothing speaks against it.");
  EXPECT_THAT(VerdictText(run.estimate, {}, {}),
              HasSubstr("as far as that can be seen without ground truth"));
}

// A mistake in the set-up that the run gave away is the cause of what is found, and told first.
TEST(Verdict, ADoubtAboutTheSetUpGoesFirst) {
  const Case run = RunAsConfigured();
  EXPECT_EQ(VerdictText(run.estimate, {}, {}, {"The corners fit a rolling shutter."}),
            "not to be relied on as it is: The corners fit a rolling shutter.");
  EXPECT_EQ(VerdictText(run.estimate, {{"Tags are off.", ""}, {"Wide.", "", true}}, {}, {"Cause."}),
            "not to be relied on as it is: Cause (and 1 more).");
}

TEST(Verdict, ALensThatIsOffIsInTheSigmasWhereItWasLearned) {
  CalibrationFlight flight = FlightAsConfigured();
  flight.config.set_up.rig.front().camera.k1 = 0.03;
  Estimate estimate = EstimateOf(flight);
  const auto of_lens = [&] { return ReprojectionFindings(estimate); };
  ASSERT_FALSE(of_lens().empty());
  ASSERT_GT(estimate.systematic.position_m, 0);
  EXPECT_TRUE(of_lens().front().is_in_sigmas);
  estimate.systematic = {};
  EXPECT_FALSE(of_lens().front().is_in_sigmas);
}

TEST(Verdict, NamesTheFirstThatSpeaksAgainstItAndHowManyMore) {
  const Case run = RunAsConfigured();
  const Finding in_sigmas{"Errors last.", "", true};
  EXPECT_EQ(
      VerdictOf(run.estimate, run, {in_sigmas, {"The lens is off.", "Calibrate."}, {"B.", ""}}),
      "not to be relied on as it is: The lens is off (and 1 more).");
  EXPECT_EQ(
      VerdictOf(run.estimate, run, {in_sigmas}),
      "to be relied on within its sigmas: nothing speaks against it. Worth a look: Errors last.");
}

TEST(Verdict, SaysWhatWasTooShortToJudge) {
  const Case run = RunAsConfigured();
  Estimate brief = run.estimate;
  brief.reprojection = {};
  brief.frames.resize(20);
  const std::string text = VerdictOf(brief, run, {});
  EXPECT_THAT(text,
              HasSubstr("nothing speaks against it, but it was too short to judge lens, map"));
  EXPECT_THAT(text, HasSubstr("errors against truth (0.8 s of it; 5 s are the least)"));
  EXPECT_EQ(VerdictOf(Estimate(), run, {}), "there is no estimate: no frame has a state.");
}

TEST(Findings, NamesErrorsThatLastWhereTheyAreMostOfTheVariance) {
  Case run = RunAsConfigured();
  SystematicShare& share = run.estimate.systematic;
  share = {0.2, 0, 0, 0, 0, 1.0, 0.1, 0.5, 0.05};
  EXPECT_THAT(run.Text(), HasSubstr("errors that last"));
  EXPECT_THAT(run.Text(), HasSubstr("0.20 px over the image"));
  share.field_sigma_px = 0.01;
  EXPECT_EQ(run.Text(), "");
  share.field_sigma_px = 0.2;
  share.position_m = 1e-6;
  EXPECT_EQ(run.Text(), "");
}

TEST(Findings, StampsOfSeveralCamerasAreNotJudgedTogether) {
  Case run = RunAsConfigured();
  const int64_t interval_ns = run.estimate.frames[1].t_ns - run.estimate.frames[0].t_ns;
  for (size_t i = 1; i < run.estimate.frames.size(); i += 3) {
    run.estimate.frames[i].t_ns -= 2 * interval_ns / 3;  // of another camera, which runs freely
  }
  EXPECT_THAT(run.Text(), HasSubstr("frames are missing"));
  run.estimate.cameras.resize(2);
  EXPECT_THAT(run.Text(), Not(HasSubstr("frames are missing")));
}

TEST(Findings, NamesNoiseThatTheErrorsBelie) {
  Case run = RunAsConfigured();
  run.estimate.noise.corner_is_given = true;
  EXPECT_EQ(run.Text(), "");
  run.estimate.noise.corner_sigma_px = 0.08;
  EXPECT_THAT(run.Text(), HasSubstr("the covariances promise too much"));
  run.estimate.noise.corner_sigma_px = 1.5;
  EXPECT_THAT(run.Text(), HasSubstr("too cautious"));
}

TEST(Findings, NamesFramesWithFewTagsAndWhatTheyCost) {
  Case run = RunAsConfigured();
  for (size_t i = 100; i < 110; ++i) {
    run.estimate.frames[i].n_tags = i < 105 ? 1 : 0;
    run.estimate.frames[i].covariance *= 100;
  }
  EXPECT_THAT(run.Text(),
              HasSubstr("4.0 % of frames (10 of 250) saw fewer than 2 tags, at 4.00 to 4.36 s; 5 "
                        "of them saw none; position is known to "));
  EXPECT_THAT(run.Text(), HasSubstr("at 4.00 to 4.36 s, where 0 to 1 tags were in use."));
}

TEST(Findings, NamesVelocitiesKnownWorseUnlessToMillimetresASecond) {
  Case run = RunAsConfigured();
  const auto text_of = [&](double usual_mps, double some_mps) {
    for (size_t k = 0; k < run.estimate.frames.size(); ++k) {
      StateCovariance& covariance = run.estimate.frames[k].covariance;
      covariance = covariance.diagonal().asDiagonal();
      covariance.diagonal().segment<3>(6).setConstant(
          std::pow(k / 5 == 20 ? some_mps : usual_mps, 2));
    }
    return run.Text();
  };
  EXPECT_THAT(text_of(0.002, 0.03), HasSubstr("Velocity is known to 0.052 m/s at worst, against"));
  EXPECT_THAT(text_of(0.0001, 0.001), Not(HasSubstr("Velocity is known")));
}

TEST(Findings, NamesFramesWithoutAState) {
  Case run = RunAsConfigured();
  for (size_t i = 0; i < 5; ++i) run.estimate.frames[i].status = FrameStatus::kNoFix;
  EXPECT_THAT(run.Text(),
              HasSubstr("2.0 % of frames (5 of 250) have no state, at 0.00 to 0.16 s."));
}

TEST(Findings, NamesMissingFrames) {
  Case run = RunAsConfigured();
  auto& frames = run.estimate.frames;
  frames.erase(frames.begin() + 200, frames.begin() + 203);
  EXPECT_EQ(run.Text(),
            "About 3 frames are missing, in gaps of more than 1.6 times the median interval of "
            "40.0 ms (1 of them); the longest is 0.16 s, from 7.96 s on.\n");
}

TEST(Findings, NamesRestlessStampsOfAWindow) {
  Case run = RunAsConfigured();
  auto& frames = run.estimate.frames;
  for (size_t i = 0; i < frames.size(); ++i) frames[i].t_ns += i % 2 == 0 ? 4'000'000 : -4'000'000;
  run.flight.ground_truth.clear();
  EXPECT_EQ(run.Text(), "") << "batch finds out by itself";
  run.estimate.mode = EstimateMode::kSlidingWindow;
  EXPECT_THAT(run.Text(),
              HasSubstr("Stamps are restless: 5.66 ms RMS around an interval of 40.0 ms."));
}

TEST(Findings, NamesAClockThatIsLate) {
  Case run = RunAsConfigured();
  for (TruthSample& sample : run.flight.ground_truth) sample.t_ns += 15'000'000;
  EXPECT_THAT(run.Text(), HasSubstr("as if truth's clock were about 15 ms late"));
  EXPECT_THAT(run.Text(), HasSubstr("NEES is "));
}

// Errors that grow for as long as truth lasts are no chance, though few of them are independent.
TEST(Findings, NamesErrorsThatGrow) {
  Case run = RunAsConfigured();
  auto& truth = run.flight.ground_truth;
  const int64_t first_ns = truth.front().t_ns;
  truth.erase(std::remove_if(truth.begin(), truth.end(),
                             [&](const auto& s) { return s.t_ns > first_ns + 4'000'000'000; }),
              truth.end());
  for (TruthSample& sample : truth) {
    const double s = ToSeconds(sample.t_ns - first_ns);
    sample.world_from_body.params(4) += 0.002 * s * s;
  }
  EXPECT_THAT(run.Text(), HasSubstr("times as large as the covariances say"));
}

TEST(Findings, NamesAConstantOffset) {
  Case run = RunAsConfigured();
  for (TruthSample& sample : run.flight.ground_truth) {
    sample.world_from_body.params(4) -= 0.01;
    sample.world_from_body.params(6) += 0.005;
  }
  EXPECT_THAT(run.Text(),
              testing::ContainsRegex("Position is off by a constant \\((9.[89]|10.[01])"));
}

// Half a second of truth is enough to see that it is of another world.
TEST(Findings, NamesShortTruthThatLiesFarOff) {
  Case run = RunAsConfigured();
  auto& truth = run.flight.ground_truth;
  const int64_t end_ns = run.flight.measurements.front().t_ns + 600'000'000;
  truth.erase(std::remove_if(truth.begin(), truth.end(),
                             [&](const TruthSample& sample) { return sample.t_ns > end_ns; }),
              truth.end());
  EXPECT_THAT(run.Text(), testing::Not(HasSubstr("Truth lies")));
  for (TruthSample& sample : truth) sample.world_from_body.params(5) += 0.5;
  EXPECT_THAT(run.Text(), testing::ContainsRegex("Truth lies (49|50).* mm off in the median"));
}

TEST(Findings, NamesAnOutlyingStretch) {
  Case run = RunAsConfigured();
  for (TruthSample& sample : run.flight.ground_truth) {
    const double t_s = ToSeconds(sample.t_ns - run.flight.measurements.front().t_ns);
    if (t_s < 6 || t_s > 6.5) continue;
    sample.world_from_body.params(6) += 0.05;
  }
  EXPECT_THAT(run.Text(), HasSubstr("Position lies far from truth at 6.00 to 6.48 s"));
}

TEST(Findings, OfNothingAreNone) {
  EXPECT_TRUE(Findings(Estimate(), {}, TagMap(), {}).empty());
  EXPECT_EQ(CertaintyText(Estimate()), "");
}

TEST(Findings, StretchesAreTheLongestInOrderOfTime) {
  std::vector<double> t_s;
  for (int i = 0; i < 20; ++i) t_s.push_back(0.5 * i);
  std::vector<bool> flags(20, false);
  for (const size_t i : {0, 2, 3, 4, 7, 8, 12, 13, 14, 15, 19}) flags[i] = true;
  EXPECT_EQ(StretchesText(t_s, flags),
            "1.00 to 2.00 s, 3.50 to 4.00 s, 6.00 to 7.50 s and 2 other times");
}

}  // namespace
}  // namespace tagtwist::internal::findings_test
