#include "estimator/batch/uneven_motion.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "estimator/motion/motion_profile.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/noise_rounds.h"

namespace tagtwist::internal {
namespace {

// In the logarithm of a likelihood: beyond doubt.
constexpr double kClearlyUneven = 10;

// Of the poses under one density, the likeliest near the learned one.
PartLikelihoods BestOfOneDensity(const MotionHistory& history, const NoiseModel& noise) {
  PartLikelihoods best{-std::numeric_limits<double>::max(), -std::numeric_limits<double>::max()};
  for (const double factor : {0.1, 0.3, 1.0, 3.0, 10.0}) {
    const PartLikelihoods here =
        history.Likelihoods(UnderOneDensity({noise.linear.on, factor * noise.linear.psd},
                                            {noise.angular.on, factor * noise.angular.psd}));
    best = {std::max(best.linear, here.linear), std::max(best.angular, here.angular)};
  }
  return best;
}

}  // namespace

Result<Solution> LetMotionVary(const EstimatorSetup& setup, const SolveOptions& options,
                               Solution solution, GraphInput* input, NoiseModel* noise) {
  if (!MotionIsLearned(setup.options)) return solution;
  const MotionHistory history = HistoryOf(setup, *noise, input->frames);
  if (!history.banks().is_measured()) return solution;
  const PartLikelihoods one = BestOfOneDensity(history, *noise),
                        many =
                            history.Likelihoods(MotionBanks(noise->linear.on, noise->angular.on));
  const MotionParts varying{many.linear > one.linear + kClearlyUneven,
                            many.angular > one.angular + kClearlyUneven};
  if (!varying.linear && !varying.angular) return solution;
  GraphInput varied = *input;
  TakeMotion(history, *noise, varying, &varied.frames);
  NoiseModel learned = *noise;
  auto out = SolveAndLearn(setup, options, &varied, &learned);
  if (!out || !(out->log_likelihood > solution.log_likelihood + kClearlyUneven)) return solution;
  *input = std::move(varied);
  *noise = learned;
  return out;
}

}  // namespace tagtwist::internal
