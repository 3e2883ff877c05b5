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
// In the logarithm of a likelihood: beyond doubt.
constexpr double kClearly = 10;

// kFrames of those with tags, in stretches of a second or so: a body that cruises for most of the
// time still starts and stops.
std::vector<GraphFrame> SpreadFrames(const std::vector<GraphFrame>& frames) {
  constexpr size_t kStretches = 6;
  std::vector<GraphFrame> with_tags, out;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) with_tags.push_back(frame);
  }
  if (with_tags.size() <= kFrames) return with_tags;
  const size_t size = kFrames / kStretches;
  for (size_t i = 0; i < kStretches; ++i) {
    const size_t begin = (with_tags.size() - size) * i / (kStretches - 1);
    const auto first = with_tags.begin() + static_cast<std::ptrdiff_t>(begin);
    out.insert(out.end(), first, first + static_cast<std::ptrdiff_t>(size));
  }
  return out;
}

struct Account {
  NoiseModel noise;
  std::optional<double> likelihood;  // an account without a solution is the least likely one
};

bool IsLikelier(const Account& a, const Account& than, double by = 0) {
  return a.likelihood && (!than.likelihood || *a.likelihood > *than.likelihood + by);
}

// Learns from `noise` on.
Account Learn(const EstimatorSetup& setup, const NoiseModel& noise,
              const std::vector<GraphFrame>& frames) {
  Account out{noise, {}};
  GraphInput input;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) input.frames.push_back(frame);
  }
  if (input.frames.empty()) return out;
  const auto solution =
      SolveAndLearn(setup, SolveOptions{setup.options.max_iterations}, &input, &out.noise);
  if (!solution) return out;
  out.likelihood = solution->log_likelihood;
  return out;
}

Account Learn(const EstimatorSetup& setup, const std::vector<FrameMeasurements>& measurements) {
  const NoiseModel noise = InitialNoise(setup.options);
  const auto seeds = SeedFrames(setup, measurements);
  return seeds ? Learn(setup, noise, *seeds) : Account{noise, {}};
}

}  // namespace

NoiseModel ChooseNoise(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames) {
  if (!MotionPriorIsOpen(setup.options)) return InitialNoise(setup.options);
  const std::vector<GraphFrame> sample = SpreadFrames(frames);
  const auto learn = [&](WhiteNoiseOn on) {
    return Learn(setup, InitialNoise(setup.options, on), sample);
  };
  const Account jerk = learn(WhiteNoiseOn::kJerk),
                acceleration = learn(WhiteNoiseOn::kAcceleration);
  return IsLikelier(acceleration, jerk) ? acceleration.noise : jerk.noise;
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
  const auto size = static_cast<std::ptrdiff_t>(std::min(kFrames, measurements.size()));
  const std::vector<FrameMeasurements> first(measurements.begin(), measurements.begin() + size);
  const Account stamped = Learn(setup, first), steady = Learn(setup, AtTimes(clock->t_ns, first));
  if (!stamped.likelihood || !IsLikelier(steady, stamped, kClearly)) return std::nullopt;
  return clock;
}

std::vector<FrameMeasurements> AtTimes(const std::vector<int64_t>& t_ns,
                                       std::vector<FrameMeasurements> measurements) {
  for (size_t i = 0; i < measurements.size(); ++i) measurements[i].t_ns = t_ns[i];
  return measurements;
}

}  // namespace tagtwist
