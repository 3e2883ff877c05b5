#include "estimator/model_choice.h"

#include <algorithm>
#include <cstddef>
#include <utility>

#include "estimator/noise_learning.h"
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
  std::vector<const GraphFrame*> with_tags;
  for (const GraphFrame& frame : frames) {
    if (!frame.tags.empty()) with_tags.push_back(&frame);
  }
  std::vector<GraphFrame> out;
  const bool all = with_tags.size() <= kFrames;
  const size_t stretches = all ? 1 : kStretches;
  const size_t size = all ? with_tags.size() : kFrames / stretches;
  for (size_t i = 0; i < stretches; ++i) {
    const size_t first = all ? 0 : (with_tags.size() - size) * i / (stretches - 1);
    for (size_t k = first; k < first + size; ++k) out.push_back(*with_tags[k]);
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

// Learns from `noise` and the frames' states on; leaves there the states that it found. Frames
// without tags are passed over.
Account Learn(const EstimatorSetup& setup, const NoiseModel& noise,
              std::vector<GraphFrame>* frames) {
  Account out{noise, {}};
  const auto is_empty = [](const GraphFrame& frame) { return frame.tags.empty(); };
  frames->erase(std::remove_if(frames->begin(), frames->end(), is_empty), frames->end());
  if (frames->empty()) return out;
  GraphInput input;
  input.frames = *frames;
  const auto solution =
      SolveAndLearn(setup, SolveOptions{setup.options.max_iterations}, &input, &out.noise);
  if (!solution) return {noise, {}};
  out.likelihood = solution->log_likelihood;
  *frames = std::move(input.frames);
  return out;
}

}  // namespace

std::optional<SteadyClock> ChooseClock(const EstimatorSetup& setup,
                                       const std::vector<GraphFrame>& frames, NoiseModel* noise) {
  if (setup.options.clock == "stamps") return std::nullopt;
  std::vector<int64_t> stamps;
  for (const GraphFrame& frame : frames) stamps.push_back(frame.t_ns);
  auto clock = FitSteadyClock(stamps);
  if (!clock || setup.options.clock == "steady") return clock;
  // Jitter this small moves nothing by as much as the corners' noise does.
  constexpr double kLeastJitterS = 2e-4;
  if (clock->rms_s < kLeastJitterS) return std::nullopt;
  const auto size = static_cast<std::ptrdiff_t>(std::min(kFrames, frames.size()));
  std::vector<GraphFrame> at_stamps(frames.begin(), frames.begin() + size), at_ticks = at_stamps;
  TakeAtTimes(clock->t_ns, &at_ticks);
  const Account stamped = Learn(setup, *noise, &at_stamps),
                steady = Learn(setup, stamped.noise, &at_ticks);
  *noise = stamped.noise;
  if (!stamped.likelihood || !IsLikelier(steady, stamped, kClearly)) return std::nullopt;
  *noise = steady.noise;
  return clock;
}

void TakeAtTimes(const std::vector<int64_t>& t_ns, std::vector<GraphFrame>* frames) {
  for (size_t i = 0; i < frames->size(); ++i) (*frames)[i].t_ns = t_ns[i];
}

NoiseModel ChooseNoise(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames,
                       const std::optional<NoiseModel>& start) {
  const NoiseModel first = start.value_or(InitialNoise(setup.options));
  if (!MotionPriorIsOpen(setup.options)) return first;  // the options say it
  std::vector<GraphFrame> sample = SpreadFrames(frames);
  const Account jerk = Learn(setup, first, &sample);
  // The frames lie where those states say; what is new is the noise of their motion.
  NoiseModel other = InitialNoise(setup.options, WhiteNoiseOn::kAcceleration);
  other.corner_sigma_px = jerk.noise.corner_sigma_px;
  const Account acceleration = Learn(setup, other, &sample);
  return IsLikelier(acceleration, jerk) ? acceleration.noise : jerk.noise;
}

}  // namespace tagtwist
