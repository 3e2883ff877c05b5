#include "estimator/model_choice.h"

#include <algorithm>
#include <cstddef>

#include "estimator/noise_learning.h"
#include "estimator/seeding.h"
#include "estimator/smoother.h"

namespace tagtwist {
namespace {

// Enough to tell the models apart, and a fraction of a long recording's cost.
constexpr size_t kFrames = 300;

// Of the tags, the noise learned; nullopt without a solution.
std::optional<double> LogLikelihood(const EstimatorSetup& setup, WhiteNoiseOn prior,
                                    const std::vector<GraphFrame>& frames) {
  GraphInput input;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) input.frames.push_back(frame);
  }
  if (input.frames.empty()) return std::nullopt;
  NoiseModel noise = InitialNoise(setup.options, prior);
  const auto solution =
      SolveAndLearn(setup, SolveOptions{setup.options.max_iterations}, &input, &noise);
  if (!solution) return std::nullopt;
  return solution->log_likelihood;
}

std::optional<double> LogLikelihood(const EstimatorSetup& setup,
                                    const std::vector<FrameMeasurements>& measurements) {
  const auto seeds = SeedFrames(setup, measurements);
  if (!seeds) return std::nullopt;
  return LogLikelihood(setup, WhiteNoiseOn::kJerk, *seeds);
}

// The middle kFrames of those with tags.
std::vector<GraphFrame> MiddleFrames(const std::vector<GraphFrame>& frames) {
  std::vector<GraphFrame> with_tags;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) with_tags.push_back(frame);
  }
  const size_t spare = with_tags.size() - std::min(kFrames, with_tags.size());
  const auto first = with_tags.begin() + static_cast<std::ptrdiff_t>(spare / 2);
  return {first, first + static_cast<std::ptrdiff_t>(with_tags.size() - spare)};
}

}  // namespace

WhiteNoiseOn ChoosePrior(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames) {
  if (!MotionPriorIsOpen(setup.options)) return WhiteNoiseOn::kJerk;  // the options say it
  const std::vector<GraphFrame> middle = MiddleFrames(frames);
  const auto jerk = LogLikelihood(setup, WhiteNoiseOn::kJerk, middle);
  const auto acceleration = LogLikelihood(setup, WhiteNoiseOn::kAcceleration, middle);
  const bool is_acceleration = acceleration && (!jerk || *acceleration > *jerk);
  return is_acceleration ? WhiteNoiseOn::kAcceleration : WhiteNoiseOn::kJerk;
}

std::optional<SteadyClock> ChooseClock(const EstimatorSetup& setup,
                                       const std::vector<FrameMeasurements>& measurements) {
  if (setup.options.clock == "stamps") return std::nullopt;
  std::vector<int64_t> stamps;
  for (const FrameMeasurements& m : measurements) stamps.push_back(m.t_ns);
  auto clock = FitSteadyClock(stamps);
  if (!clock || setup.options.clock == "steady") return clock;
  // Jitter this small moves nothing by as much as the corners' noise does.
  constexpr double kLeastJitterS = 2e-4;
  if (clock->rms_s < kLeastJitterS) return std::nullopt;
  constexpr double kClearly = 10;  // in the logarithm: beyond doubt
  const auto size = static_cast<std::ptrdiff_t>(std::min(kFrames, measurements.size()));
  const std::vector<FrameMeasurements> first(measurements.begin(), measurements.begin() + size);
  const auto stamped = LogLikelihood(setup, first);
  const auto steady = LogLikelihood(setup, AtTimes(clock->t_ns, first));
  if (!stamped || !steady || !(*steady > *stamped + kClearly)) return std::nullopt;
  return clock;
}

std::vector<FrameMeasurements> AtTimes(const std::vector<int64_t>& t_ns,
                                       std::vector<FrameMeasurements> measurements) {
  for (size_t i = 0; i < measurements.size(); ++i) measurements[i].t_ns = t_ns[i];
  return measurements;
}

}  // namespace tagtwist
