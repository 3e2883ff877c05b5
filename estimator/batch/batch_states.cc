#include "estimator/batch/batch_states.h"

#include <utility>

#include "estimator/graph/pose_bound.h"
#include "estimator/motion/motion_profile.h"
#include "estimator/motion/open_motion_of_chain.h"
#include "estimator/motion/unfollowed_motion.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/solve/prior_power.h"
#include "estimator/systematic/systematic_errors.h"

namespace tagtwist::internal {

std::vector<int> StatesOfFrames(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames,
                                const std::vector<TrackSegment>& segments) {
  std::vector<bool> sees(frames.size());
  for (size_t i = 0; i < frames.size(); ++i) sees[i] = !frames[i].tags.empty();
  if (setup.options.use_tracks) {
    for (const TrackSegment& segment : segments) {
      for (int i = segment.first_frame; i <= segment.last_frame(); ++i) {
        sees[static_cast<size_t>(i)] = true;
      }
    }
  }
  std::vector<int> state_of_frame;
  int n_states = 0;
  for (const bool has_state : sees) state_of_frame.push_back(has_state ? n_states++ : -1);
  return state_of_frame;
}

std::vector<const std::vector<TagDetection>*> TagsOfStates(
    const std::vector<FrameMeasurements>& measurements, const std::vector<int>& state_of_frame,
    size_t n_states) {
  static const std::vector<TagDetection> none;
  std::vector<const std::vector<TagDetection>*> out(n_states, &none);
  for (size_t i = 0; i < state_of_frame.size(); ++i) {
    const int k = state_of_frame[i];
    if (k >= 0) out[static_cast<size_t>(k)] = &measurements[i].tags;
  }
  return out;
}

GraphInput InputOfStates(const std::vector<int>& state_of_frame,
                         const std::vector<TrackSegment>& segments,
                         std::vector<GraphFrame>* frames) {
  GraphInput input;
  for (size_t i = 0; i < frames->size(); ++i) {
    if (state_of_frame[i] >= 0) input.frames.push_back(std::move((*frames)[i]));
  }
  for (const TrackSegment& segment : segments) {
    const int state = state_of_frame[static_cast<size_t>(segment.first_frame)];
    if (state < 0) continue;  // tracks are not used
    input.segments.push_back(segment);
    input.segments.back().first_frame = state;
  }
  return input;
}

std::vector<StateCovariance> BodyCovariances(const BlockBandedMatrix& covariance) {
  std::vector<StateCovariance> out;
  for (int k = 0; k < covariance.size(); ++k) out.push_back(BodyCovariance(covariance, k));
  return out;
}

std::vector<StateCovariance> StateCovariances(const EstimatorSetup& setup, const NoiseModel& noise,
                                              const std::vector<GraphFrame>& frames,
                                              const Solution& solution) {
  std::vector<StateCovariance> out;
  if (MotionIsLearned(setup.options)) {
    PriorPower prior = FindPriorPower(solution.graph);
    const double power = prior.statistic.Power();
    out = WithPriorPower(power, std::move(prior));
  }
  if (out.empty()) out = BodyCovariances(solution.covariance);
  AddOpenMotion({solution.graph.states, solution.covariance, noise}, LearnedParts(setup.options),
                setup.for_ranges, &out);
  AddUnfollowedMotion(setup, noise.corner_sigma_px, LearnedParts(setup.options),
                      solution.graph.states, frames, &out);
  return out;
}

Trajectory MakeTrajectory(const std::vector<GraphState>& states, BlockBandedMatrix covariance,
                          const NoiseModel& noise) {
  Trajectory out;
  out.linear = noise.linear;
  out.angular = noise.angular;
  out.states = states;
  if (covariance.bandwidth() > 0) out.cross_covariances = covariance.TakeDiagonal(1);
  out.covariances = covariance.TakeDiagonal(0);
  return out;
}

SystematicShare AddSystematic(const EstimatorSetup& setup, const NoiseModel& noise,
                              const Graph& graph, const std::vector<GraphFrame>& frames,
                              Trajectory* trajectory, std::vector<StateCovariance>* covariances) {
  if (!setup.options.systematic_errors) return {};
  const SystematicBasis basis(setup, TagsSeenMost(frames));
  const SystematicErrors errors = LearnSystematicErrors(basis, noise, frames);
  return AddSystematicErrors(basis, errors, noise, graph, frames, trajectory, covariances);
}

void PutBack(const std::vector<int>& state_of_frame, const Trajectory& trajectory,
             GraphInput* input, std::vector<GraphFrame>* frames) {
  for (size_t i = 0; i < frames->size(); ++i) {
    GraphFrame& frame = (*frames)[i];
    const int k = state_of_frame[i];
    if (k >= 0) {
      frame = std::move(input->frames[static_cast<size_t>(k)]);
    } else {
      frame.state = trajectory.At(frame.t_ns)->state;
    }
  }
}

void FillFrames(const EstimatorSetup& setup, const SolvedFrames& solved,
                const std::vector<StateCovariance>& covariances, const std::vector<int>& n_tracks,
                const std::optional<SteadyClock>& clock, Estimate* out) {
  const auto fill = [&](size_t i) {
    const int k = solved.state_of_frame[i];
    const GraphFrame& frame = solved.frames[i];
    StateAndCovariance at{frame.state, StateCovariance::Zero()};
    // A row says where the body was when its frame was taken; the stamp is the frame's name.
    if (k >= 0) {
      at.covariance = covariances[static_cast<size_t>(k)];
    } else {
      at = *out->trajectory.At(frame.t_ns);
      if (clock) at.covariance += OfClock(at.state, clock->sigma_s[i]);
    }
    if (!clock && setup.options.stamp_sigma_s) {
      at.covariance += OfClock(at.state, *setup.options.stamp_sigma_s);
    }
    FrameEstimate& row = out->frames[i];
    row = ToFrameEstimate(solved.measurements[i].closed_form, n_tracks[i], frame, at.covariance);
    row.t_ns = solved.measurements[i].t_ns;
    row.state = at.state;
    row.pose_bound =
        PoseBound(setup, out->noise.corner_sigma_px, frame.state.world_from_body, frame.tags);
  };
  out->frames.resize(solved.frames.size());
  setup.for_ranges(solved.frames.size(), [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) fill(i);
  });
}

}  // namespace tagtwist::internal
