#include "estimator/batch/first_solve.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "estimator/motion/turn_or_move.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/noise_rounds.h"

namespace tagtwist::internal {
namespace {

struct Motion {
  BodyState state;
  Acceleration acceleration;
};

std::vector<Motion> MotionOf(const std::vector<GraphFrame>& frames) {
  std::vector<Motion> out;
  out.reserve(frames.size());
  for (const GraphFrame& frame : frames) out.push_back({frame.state, frame.acceleration});
  return out;
}

void PutBack(const std::vector<Motion>& motion, std::vector<GraphFrame>* frames) {
  for (size_t k = 0; k < motion.size(); ++k) {
    (*frames)[k].state = motion[k].state;
    (*frames)[k].acceleration = motion[k].acceleration;
  }
}

// By what the corners' noise may exceed that of the sample before the solution is suspect. Where
// frames leave two poses open it may lie between both, its corners little off.
double MostTimes(const std::vector<GraphFrame>& frames) {
  constexpr double kBetweenPoses = 1.15, kFarOff = 3;
  const bool any_open = std::any_of(frames.begin(), frames.end(),
                                    [](const GraphFrame& frame) { return frame.leaves_open; });
  return any_open ? kBetweenPoses : kFarOff;
}

// As the noise is to begin with, or again where the first solution's is far off.
Result<Solution> SolveOnceOrTwice(const EstimatorSetup& setup, const SolveOptions& options,
                                  GraphInput* input, NoiseModel* noise) {
  const std::vector<Motion> starts = MotionOf(input->frames);
  const double most_px = MostTimes(input->frames) * noise->corner_sigma_px;
  NoiseModel anew = InitialNoise(setup.options, noise->linear.on);
  auto first = SolveAndLearn(setup, options, input, noise);
  if (first && !(noise->corner_sigma_px > most_px)) return first;
  const std::vector<Motion> of_first = MotionOf(input->frames);
  PutBack(starts, &input->frames);
  auto second = SolveAndLearn(setup, options, input, &anew);
  if (!second || (first && first->log_likelihood >= second->log_likelihood)) {
    PutBack(of_first, &input->frames);
    return first;
  }
  *noise = anew;
  return second;
}

}  // namespace

Result<Solution> SolveFromStarts(const EstimatorSetup& setup, const SolveOptions& options,
                                 GraphInput* input, NoiseModel* noise) {
  const NoiseModel start = *noise;
  auto solution = SolveOnceOrTwice(setup, options, input, noise);
  if (!MotionIsLearned(setup.options) || noise->linear.on != noise->angular.on) return solution;
  if (!solution) *noise = start;
  noise->lever_m = LeverOfUntold(setup, *noise, input->frames);
  if (!(noise->lever_m > 0)) return solution;
  if (MotionPriorIsOpen(setup.options)) {
    // Which of the two tags do not tell either, and white jerk is not as sure.
    const NoiseModel anew = InitialNoise(setup.options, WhiteNoiseOn::kJerk);
    if (noise->linear.on != anew.linear.on) {
      noise->linear = anew.linear;
      noise->angular = anew.angular;
    }
  }
  return SolveAndLearn(setup, options, input, noise);
}

}  // namespace tagtwist::internal
