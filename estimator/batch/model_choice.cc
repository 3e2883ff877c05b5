#include "estimator/batch/model_choice.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "estimator/graph/noise_model.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/solve/smoother.h"
#include "frontend/base/statistics/quantile.h"

namespace tagtwist::internal {
namespace {

// In the logarithm of a likelihood: beyond doubt.
constexpr double kClearly = 10;

// Stretches of a recording to learn from, and how well the noise must settle on them. The first
// tells the orders of magnitude, the last is enough to tell models apart, and a fraction of a long
// recording's cost; each starts where the one before has ended.
struct Sample {
  size_t stretches, frames_each;
  LearnOptions learn;  // few frames must not claim a density that is next to nothing
  size_t size() const { return stretches * frames_each; }
};
constexpr Sample kRough{2, 24, {0.5, 10}}, kSmall{6, 24, {0.03, 10}}, kWhole{6, 50, {0.01, 1}};

std::vector<GraphFrame> WithTags(const std::vector<GraphFrame>& frames) {
  std::vector<GraphFrame> out;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) out.push_back(frame);
  }
  return out;
}

// The sample of these frames, spread over them: a body that cruises for most of the time still
// starts and stops.
std::vector<GraphFrame> Take(const Sample& sample, const std::vector<GraphFrame>& frames) {
  if (frames.size() <= sample.size()) return frames;
  std::vector<GraphFrame> out;
  size_t end = 0;
  for (size_t i = 0; i < sample.stretches; ++i) {
    const size_t spread =
        (frames.size() - sample.frames_each) * (2 * i + 1) / (2 * sample.stretches);
    // No frame twice, and room for the stretches that follow.
    const size_t latest = frames.size() - (sample.stretches - i) * sample.frames_each;
    const size_t first = std::max(end, std::min(spread, latest));
    end = first + sample.frames_each;
    for (size_t k = first; k < end; ++k) out.push_back(frames[k]);
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

// Learns from `noise` and the frames' states on; leaves there the states that it found.
Account Learn(const EstimatorSetup& setup, const NoiseModel& noise, const LearnOptions& learn,
              std::vector<GraphFrame>* frames) {
  Account out{noise, {}};
  if (frames->empty()) return out;
  GraphInput input;
  input.frames = std::move(*frames);
  const auto solution =
      SolveAndLearn(setup, SolveOptions{setup.options.max_iterations}, &input, &out.noise, learn);
  *frames = std::move(input.frames);
  if (!solution) return {noise, {}};
  out.likelihood = solution->log_likelihood;
  return out;
}

// The orders of magnitude of the noise, from there on.
NoiseModel LearnRoughly(const EstimatorSetup& setup, const NoiseModel& noise,
                        const std::vector<GraphFrame>& frames) {
  std::vector<GraphFrame> sample = Take(kRough, frames);
  return Learn(setup, noise, kRough.learn, &sample).noise;
}

}  // namespace

namespace {

// The frames at their stamps and at a clock's ticks, under the noise that each learns.
struct ClockAccounts {
  Account stamped, steady;
};

ClockAccounts CompareClocks(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames,
                            const SteadyClock& clock, const NoiseModel& start,
                            const LearnOptions& learn) {
  std::vector<GraphFrame> ticking = frames;
  TakeAtTimes(clock.t_ns, &ticking);
  std::vector<GraphFrame> at_stamps = WithTags(frames), at_ticks = WithTags(ticking);
  ClockAccounts out;
  out.stamped = Learn(setup, LearnRoughly(setup, start, at_stamps), learn, &at_stamps);
  out.steady = Learn(setup, out.stamped.noise, learn, &at_ticks);
  return out;
}

// Whether a quarter of the frames came in less than an eighth of the usual interval after the one
// before, which no camera does: then the stamps are a host's, of when it took frames in pairs.
bool AreOfArrival(const std::vector<int64_t>& stamps_ns) {
  std::vector<double> intervals_s;
  for (size_t i = 1; i < stamps_ns.size(); ++i) {
    intervals_s.push_back(ToSeconds(stamps_ns[i] - stamps_ns[i - 1]));
  }
  const double usual_s = Quantile(intervals_s, 0.75);
  const auto soon = std::count_if(intervals_s.begin(), intervals_s.end(),
                                  [&](double interval_s) { return interval_s < usual_s / 8; });
  return 4 * static_cast<size_t>(soon) >= intervals_s.size();
}

}  // namespace

std::optional<SteadyClock> ChooseClock(const EstimatorSetup& setup,
                                       const std::vector<GraphFrame>& frames, NoiseModel* noise) {
  if (setup.options.clock == ClockChoice::kStamps) return std::nullopt;
  std::vector<int64_t> stamps;
  for (const GraphFrame& frame : frames) stamps.push_back(frame.t_ns);
  auto clock = FitSteadyClock(stamps);
  if (!clock || setup.options.clock == ClockChoice::kSteady) return clock;
  if (AreOfArrival(stamps)) return clock;
  // Jitter this small moves nothing by as much as the corners' noise does.
  constexpr double kLeastJitterS = 2e-4;
  if (clock->rms_s < kLeastJitterS) return std::nullopt;
  const auto of_first = [&](size_t most, const LearnOptions& learn) {
    const auto size = static_cast<std::ptrdiff_t>(std::min(most, frames.size()));
    return CompareClocks(setup, {frames.begin(), frames.begin() + size}, *clock, *noise, learn);
  };
  // Times that are wrong by more than the corners can bear settle on no noise, and need not.
  constexpr double kBeyondPrecision = 10 * kClearly;
  ClockAccounts accounts = of_first(kSmall.size(), {0.1, kWhole.learn.least_dof});
  if (!IsLikelier(accounts.stamped, accounts.steady, kBeyondPrecision) &&
      !IsLikelier(accounts.steady, accounts.stamped, kBeyondPrecision)) {
    accounts = of_first(kWhole.size(), kWhole.learn);
  }
  *noise = accounts.stamped.noise;
  if (!IsLikelier(accounts.steady, accounts.stamped, kClearly)) return std::nullopt;
  *noise = accounts.steady.noise;
  return clock;
}

void TakeAtTimes(const std::vector<int64_t>& t_ns, std::vector<GraphFrame>* frames) {
  for (size_t i = 0; i < frames->size(); ++i) (*frames)[i].t_ns = t_ns[i];
}

NoiseModel ChooseNoise(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames,
                       const std::optional<NoiseModel>& start) {
  NoiseModel jerk_noise = start.value_or(InitialNoise(setup.options));
  if (!AnyNoiseIsOpen(setup.options)) return jerk_noise;
  const std::vector<GraphFrame> with_tags = WithTags(frames);
  jerk_noise = LearnRoughly(setup, jerk_noise, with_tags);
  if (!MotionPriorIsOpen(setup.options)) return jerk_noise;  // the options say which
  NoiseModel acceleration_noise = InitialNoise(setup.options, WhiteNoiseOn::kAcceleration);
  acceleration_noise.corner_sigma_px = jerk_noise.corner_sigma_px;
  acceleration_noise = LearnRoughly(setup, acceleration_noise, with_tags);
  Account jerk, acceleration;
  for (const Sample& sample : {kSmall, kWhole}) {
    std::vector<GraphFrame> of_sample = Take(sample, with_tags);
    jerk = Learn(setup, jerk_noise, sample.learn, &of_sample);
    // The frames lie where those states say; what is new is the noise of their motion.
    acceleration = Learn(setup, acceleration_noise, sample.learn, &of_sample);
    jerk_noise = jerk.noise;
    acceleration_noise = acceleration.noise;
  }
  return IsLikelier(acceleration, jerk) ? acceleration.noise : jerk.noise;
}

}  // namespace tagtwist::internal
