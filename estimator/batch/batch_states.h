#pragma once
#include <optional>
#include <vector>

#include "estimator/batch/batch_audit.h"
#include "estimator/graph/graph.h"
#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/track_segments.h"
#include "estimator/graph/trajectory.h"
#include "estimator/linear/block_banded.h"
#include "estimator/result/estimate.h"
#include "estimator/result/systematic_share.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/steady_clock.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// The state of each frame in the graph; -1 for frames that see nothing. Those need no state: the
/// trajectory between the others says all of them, and over a long gap a chain of states, tied by
/// nothing but the stiff motion prior, would be badly conditioned.
std::vector<int> StatesOfFrames(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames,
                                const std::vector<TrackSegment>& segments);

/// The tags that the frame of each state saw; none in a state that is no frame's.
std::vector<const std::vector<TagDetection>*> TagsOfStates(
    const std::vector<FrameMeasurements>& measurements, const std::vector<int>& state_of_frame,
    size_t n_states);

/// Frames with a state, taken from `frames`, and the segments counted in states.
GraphInput InputOfStates(const std::vector<int>& state_of_frame,
                         const std::vector<TrackSegment>& segments,
                         std::vector<GraphFrame>* frames);

/// Those of a covariance as it is.
std::vector<StateCovariance> BodyCovariances(const BlockBandedMatrix& covariance);

/// Covariances of all states of a solution; where the prior's densities are learned, scaled by its
/// power, and with what is open of the motion's liveliness and what of it the states do not follow.
std::vector<StateCovariance> StateCovariances(const EstimatorSetup& setup, const NoiseModel& noise,
                                              const std::vector<GraphFrame>& frames,
                                              const Solution& solution);

/// These states with their covariances. Takes the covariance's place: of long recordings both would
/// be a lot to hold.
Trajectory MakeTrajectory(const std::vector<GraphState>& states, BlockBandedMatrix covariance,
                          const NoiseModel& noise);

/// What lens, map and corners do to the states, over and over the same, goes into their covariances
/// and those of the trajectory, where the options say so.
SystematicShare AddSystematic(const EstimatorSetup& setup, const NoiseModel& noise,
                              const Graph& graph, const std::vector<GraphFrame>& frames,
                              Trajectory* trajectory, std::vector<StateCovariance>* covariances);

/// Frames with a state out of the input again; the others take theirs from the trajectory.
void PutBack(const std::vector<int>& state_of_frame, const Trajectory& trajectory,
             GraphInput* input, std::vector<GraphFrame>* frames);

/// The rows of all frames, from where the graph has them; of those that had no state in it (-1)
/// from the trajectory.
void FillFrames(const EstimatorSetup& setup, const SolvedFrames& solved,
                const std::vector<StateCovariance>& covariances, const std::vector<int>& n_tracks,
                const std::optional<SteadyClock>& clock, Estimate* out);

}  // namespace tagtwist::internal
