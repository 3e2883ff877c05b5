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

// Of the tags, with the noise learned from `noise` on; nullopt without a solution.
std::optional<double> LearnLikelihood(const EstimatorSetup& setup,
                                      const std::vector<GraphFrame>& frames, NoiseModel* noise) {
  GraphInput input;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) input.frames.push_back(frame);
  }
  if (input.frames.empty()) return std::nullopt;
  const auto solution =
      SolveAndLearn(setup, SolveOptions{setup.options.max_iterations}, &input, noise);
  if (!solution) return std::nullopt;
  return solution->log_likelihood;
}

std::optional<double> LogLikelihood(const EstimatorSetup& setup,
                                    const std::vector<FrameMeasurements>& measurements) {
  const auto seeds = SeedFrames(setup, measurements);
  if (!seeds) return std::nullopt;
  NoiseModel noise = InitialNoise(setup.options);
  return LearnLikelihood(setup, *seeds, &noise);
}

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

// Likelier with `other`? An account without a solution is the less likely one.
bool IsLikelier(const std::optional<double>& other, const std::optional<double>& than) {
  return other && (!than || *other > *than);
}

}  // namespace

NoiseModel ChooseNoise(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames) {
  MotionKinds kinds;
  NoiseModel chosen = InitialNoise(setup.options, kinds);
  if (!MotionPriorIsOpen(setup.options)) return chosen;  // the options say it
  const std::vector<GraphFrame> sample = SpreadFrames(frames);
  auto likelihood = LearnLikelihood(setup, sample, &chosen);
  for (WhiteNoiseOn MotionKinds::*part : {&MotionKinds::linear, &MotionKinds::angular}) {
    MotionKinds other = kinds;
    other.*part = WhiteNoiseOn::kAcceleration;
    NoiseModel noise = InitialNoise(setup.options, other);
    const auto of_other = LearnLikelihood(setup, sample, &noise);
    if (!IsLikelier(of_other, likelihood)) continue;
    kinds = other;
    chosen = noise;
    likelihood = of_other;
  }
  return chosen;
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
