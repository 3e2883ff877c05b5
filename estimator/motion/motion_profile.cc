#include "estimator/motion/motion_profile.h"

#include <algorithm>

namespace tagtwist::internal {

MotionHistory HistoryOf(const EstimatorSetup& setup, const NoiseModel& noise,
                        const std::vector<GraphFrame>& frames, bool keeps_past) {
  MotionHistory out(noise, keeps_past);
  for (const GraphFrame& frame : frames) out.Add(setup, noise, frame);
  return out;
}

MotionParts LearnedParts(const EstimatorOptions& options) {
  return {!options.accel_psd && !options.jerk_psd,
          !options.angular_accel_psd && !options.angular_jerk_psd};
}

MotionParts VaryingParts(const MotionHistory& history, const EstimatorOptions& options) {
  const MotionParts learned = LearnedParts(options);
  // What a lone tag shows is motion, however little its states tell: the learned densities may be
  // far too small.
  const bool any = history.FollowsTag();
  return {learned.linear && (any || history.LinearVaries()),
          learned.angular && (any || history.AngularVaries())};
}

void TakeMotion(const MotionHistory& history, const NoiseModel& noise, const MotionParts& varying,
                std::vector<GraphFrame>* frames) {
  const auto densities = history.FromBothSides(varying);
  const MotionParts besides = {varying.linear && history.LinearVaries(),
                               varying.angular && history.AngularVaries()};
  for (size_t k = 0; k < frames->size(); ++k) {
    MotionScale& motion = (*frames)[k].motion;
    motion = MotionScale{1, 1, motion.breaks};
    if (motion.breaks) continue;
    const bool is_lone = history.IsOfWindow() && LoneTag((*frames)[k].tags);
    const MotionParts& of = history.FollowsTag() && !is_lone ? besides : varying;
    // A body that turns as it moves, so that a tag keeps its place in view, looks like rest.
    const double least = is_lone ? 1 : 0;
    if (of.linear) motion.linear = std::max(least, densities[k].linear / noise.linear.psd);
    if (of.angular) motion.angular = std::max(least, densities[k].angular / noise.angular.psd);
  }
}

}  // namespace tagtwist::internal
