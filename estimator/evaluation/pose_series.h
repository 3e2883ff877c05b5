#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"

namespace tagtwist {

/// One pose of a trajectory that is judged or drawn, with what else is known at that time.
struct PoseSample {
  int64_t t_ns = 0;
  Pose world_from_body;
  std::optional<Twist> twist;
  std::optional<StateCovariance> covariance;  // error state of BodyState
};
using PoseSeries = std::vector<PoseSample>;

/// Frames that have a state, with its covariance.
PoseSeries EstimatedSeries(const std::vector<FrameEstimate>& frames);

/// Frames that have a closed-form pose, with the twist of the variant.
enum class ClosedFormVariant { kPlain, kRansac, kLowPass };
PoseSeries ClosedFormSeries(const std::vector<FrameEstimate>& frames, ClosedFormVariant variant);

/// The trajectory at a time: a sample of exactly that stamp as it is; otherwise between its two
/// neighbours, when they are at most max_gap_s apart: position and rotation cubic by the twists
/// of an estimate with covariances (others' twists are mostly too noisy), else linear; twist and
/// covariance linear. nullopt outside the series and in gaps. Stamps grow strictly.
std::optional<PoseSample> SampleAt(const PoseSeries& series, int64_t t_ns, double max_gap_s);

/// The sample as seen by somebody who measures the frame `marker` fixed to the body, in the world
/// `truth`: pose truth_from_world * world_from_body * body_from_marker, and the twist and the
/// covariance that belong to it.
PoseSample Transform(const PoseSample& sample, const Pose& truth_from_world,
                     const Pose& body_from_marker);

/// How restless a signal is: the RMS of its second differences over neighbouring samples, divided
/// by sqrt(6), which is the 3-D standard deviation where the signal is slow and its noise white.
/// It needs no ground truth. nullopt for fewer than three neighbouring twists.
struct TwistRoughness {
  double velocity_mps = 0, rate_radps = 0;
};
std::optional<TwistRoughness> ComputeRoughness(const PoseSeries& series);

}  // namespace tagtwist
