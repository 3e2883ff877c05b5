#include "estimator/motion/motion_profile.h"

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
  return {learned.linear && history.LinearVaries(), learned.angular && history.AngularVaries()};
}

void TakeMotion(const MotionHistory& history, const NoiseModel& noise, const MotionParts& varying,
                std::vector<GraphFrame>* frames) {
  const auto densities = history.FromBothSides(varying);
  for (size_t k = 0; k < frames->size(); ++k) {
    MotionScale& motion = (*frames)[k].motion;
    motion = MotionScale{1, 1, motion.breaks};
    if (motion.breaks) continue;
    if (varying.linear) motion.linear = densities[k].linear / noise.linear.psd;
    if (varying.angular) motion.angular = densities[k].angular / noise.angular.psd;
  }
}

}  // namespace tagtwist::internal
