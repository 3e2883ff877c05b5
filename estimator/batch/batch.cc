#include "estimator/batch/batch.h"

#include <string>
#include <utility>

#include "estimator/batch/model_choice.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/pose_bound.h"
#include "estimator/graph/reprojection.h"
#include "estimator/result/tag_audit.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/solve/prior_power.h"
#include "estimator/start/recording_start.h"
#include "estimator/start/tags_at_stamp.h"
#include "frontend/base/format_text.h"

namespace tagtwist {
namespace {

// Takes the solution's place: of long recordings both would be a lot to hold.
Trajectory MakeTrajectory(Solution solution, const NoiseModel& noise) {
  Trajectory out;
  out.linear = noise.linear;
  out.angular = noise.angular;
  out.states = std::move(solution.graph.states);
  solution.graph = Graph();
  for (int k = 0; k < solution.covariance.size(); ++k) {
    out.covariances.push_back(solution.covariance.At(k, k));
    if (k + 1 < solution.covariance.size()) {
      out.cross_covariances.push_back(solution.covariance.At(k + 1, k));
    }
  }
  return out;
}

// The state of each frame in the graph; -1 for frames that see nothing. Those need no state: the
// trajectory between the others says all of them, and over a long gap a chain of states, tied by
// nothing but the stiff motion prior, would be badly conditioned.
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

// Frames with a state, taken from `frames`, and the segments counted in states.
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

// Covariances of all states; scaled by the prior's power where the prior's densities are learned.
std::vector<StateCovariance> StateCovariances(const EstimatorOptions& options,
                                              const Solution& solution) {
  std::vector<StateCovariance> out;
  if (MotionIsLearned(options)) {
    const PriorPower prior = FindPriorPower(solution.graph);
    out = WithPriorPower(prior.statistic.Power(), prior);
  }
  if (!out.empty()) return out;
  for (int k = 0; k < solution.covariance.size(); ++k) {
    out.push_back(BodyCovariance(solution.covariance, k));
  }
  return out;
}

// Covariance by the clock's own uncertainty, which moves a state along its motion. Accelerations
// matter less and are left out.
StateCovariance OfClock(const BodyState& state, double sigma_s) {
  StateVector by_time = StateVector::Zero();
  by_time.head<6>() << state.twist.omega_body, state.twist.v_world;
  return sigma_s * sigma_s * by_time * by_time.transpose();
}

std::string ClockText(const SteadyClock& clock) {
  return Format(
      "the camera's clock is steady at %.3f ms, the stamps scatter by %.2f ms RMS around it: "
      "frames are taken at its ticks",
      1e3 * clock.period_s, 1e3 * clock.rms_s);
}

}  // namespace

BatchEstimator::BatchEstimator(EstimatorSetup setup)
    : setup_(std::move(setup)),
      segmenter_({setup_.options.max_tracks_per_frame, setup_.options.track_segment_frames}),
      set_up_check_(setup_.map, setup_.camera),
      gate_(setup_.map, setup_.camera) {}

void BatchEstimator::Add(FrameMeasurements measurement) {
  segmenter_.Add(measurement.tracks, static_cast<int>(measurement.tags.size()));
  n_tracks_.push_back(static_cast<int>(measurement.tracks.size()));
  measurement.tracks = {};
  if (set_up_is_right_) set_up_is_right_ = set_up_check_.Add(measurement.tags);
  auto refused = gate_.TakeRefused(&measurement.tags);
  if (!refused.empty()) refused_.emplace(measurements_.size(), std::move(refused));
  measurements_.push_back(std::move(measurement));
}

Result<Solution> BatchEstimator::SolveWithTrustedTags(const std::vector<int>& state_of_frame,
                                                      GraphInput* input, NoiseModel* noise) const {
  const SolveOptions options{setup_.options.max_iterations};
  auto solution = SolveAndLearn(setup_, options, input, noise);
  if (!solution) return solution;
  std::vector<const std::vector<TagDetection>*> seen;  // in each state
  for (size_t i = 0; i < state_of_frame.size(); ++i) {
    if (state_of_frame[i] >= 0) seen.push_back(&measurements_[i].tags);
  }
  // What is left out may have misled a start or hidden another fault: until nothing changes.
  constexpr int kMaxRounds = 4;
  for (int round = 0; round < kMaxRounds; ++round) {
    const bool readmit = round == 0;
    if (!ReviseTags(setup_, *noise, solution->graph, seen, readmit, &input->frames)) break;
    *solution = Solution();  // its memory is for the next
    solution = SolveAndLearn(setup_, options, input, noise);
    if (!solution) return solution;
  }
  return solution;
}

void BatchEstimator::TakeTagsAsOfStamps(double line_time_s,
                                        const std::vector<FrameEstimate>& solved) {
  for (size_t i = 0; i < measurements_.size(); ++i) {
    std::vector<TagDetection>& tags = measurements_[i].tags;
    tags = TagsAsOfStamp(setup_, line_time_s, solved[i].state, tags);
  }
}

void BatchEstimator::FillFrames(std::vector<GraphFrame> solved,
                                const std::vector<int>& state_of_frame,
                                const std::vector<StateCovariance>& covariances,
                                const std::optional<SteadyClock>& clock, BatchResult* out) const {
  const auto fill = [&](size_t i) {
    const int k = state_of_frame[i];
    GraphFrame& frame = solved[i];
    StateAndCovariance at{frame.state, StateCovariance::Zero()};
    if (k >= 0) at.covariance = covariances[static_cast<size_t>(k)];
    if (k < 0 || clock) {
      // A row says where the body was at its stamp.
      const StateCovariance calibration =
          k < 0 ? StateCovariance(StateCovariance::Zero())
                : StateCovariance(
                      at.covariance -
                      out->trajectory.covariances[static_cast<size_t>(k)].topLeftCorner<12, 12>());
      at = *out->trajectory.At(measurements_[i].t_ns);
      at.covariance += calibration;
      if (clock) at.covariance += OfClock(at.state, clock->sigma_s[i]);
    }
    const auto bound =
        PoseBound(setup_, out->noise.corner_sigma_px, frame.state.world_from_body, frame.tags);
    frame.t_ns = measurements_[i].t_ns;
    frame.state = at.state;
    out->frames[i] =
        ToFrameEstimate(measurements_[i].closed_form, n_tracks_[i], frame, at.covariance);
    out->frames[i].pose_bound = bound;
  };
  out->frames.resize(solved.size());
  setup_.for_ranges(solved.size(), [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) fill(i);
  });
}

TagAudit BatchEstimator::Audit(const std::vector<GraphFrame>& solved,
                               const std::vector<int>& state_of_frame, BatchResult* out) const {
  TagAudit audit;
  ReprojectionTally tally;
  for (size_t i = 0; i < solved.size(); ++i) {
    const GraphFrame& frame = solved[i];
    std::vector<TagDetection> seen = measurements_[i].tags;
    const auto refused = refused_.find(i);
    if (refused != refused_.end()) {
      seen.insert(seen.end(), refused->second.begin(), refused->second.end());
    }
    audit.Add(setup_, frame, seen);
    if (state_of_frame[i] < 0) continue;
    const std::vector<double> errors = ReprojectionErrors(setup_, frame);
    out->reprojection_px.insert(out->reprojection_px.end(), errors.begin(), errors.end());
    tally.Add(setup_.camera, setup_.map, frame.t_ns,
              setup_.cam_from_body * Inverse(frame.state.world_from_body), frame.tags);
  }
  out->reprojection = tally.Errors();
  return audit;
}

Result<BatchResult> BatchEstimator::Solve() const {
  if (!set_up_is_right_) return set_up_is_right_.error();
  if (const auto fine = set_up_check_.Finish(); !fine) return fine.error();
  auto starts = StartFrames(setup_, measurements_);
  if (!starts) return starts.error();
  BatchResult out;
  out.noise = InitialNoise(setup_.options);
  const std::optional<SteadyClock> clock = ChooseClock(setup_, *starts, &out.noise);
  if (clock) TakeAtTimes(clock->t_ns, &*starts);
  out.noise = ChooseNoise(setup_, *starts, out.noise);
  const std::vector<int> state_of_frame = StatesOfFrames(setup_, *starts, segmenter_.segments());
  GraphInput input = InputOfStates(state_of_frame, segmenter_.segments(), &*starts);
  TrackTally tracks = TallyOf(input.segments);
  auto solution = SolveWithTrustedTags(state_of_frame, &input, &out.noise);
  if (!solution) return solution.error();

  const std::vector<StateCovariance> covariances = StateCovariances(setup_.options, *solution);
  out.trajectory = MakeTrajectory(std::move(*solution), out.noise);
  for (size_t i = 0; i < starts->size(); ++i) {
    GraphFrame& frame = (*starts)[i];
    const int k = state_of_frame[i];
    if (k >= 0) {
      frame = std::move(input.frames[static_cast<size_t>(k)]);
    } else {
      frame.state = out.trajectory.At(frame.t_ns)->state;
    }
  }
  const TagAudit audit = Audit(*starts, state_of_frame, &out);
  FillFrames(std::move(*starts), state_of_frame, covariances, clock, &out);
  out.warnings = audit.Warnings();
  tracks.contradicted = tracks.used - TallyOf(input.segments).used;
  if (const auto of_tracks = tracks.Warning()) out.warnings.push_back(*of_tracks);
  if (clock) out.warnings.push_back(ClockText(*clock));
  return out;
}

Result<BatchResult> RunBatch(const EstimatorSetup& setup,
                             const std::vector<FrameMeasurements>& measurements) {
  BatchEstimator batch(setup);
  for (const FrameMeasurements& m : measurements) batch.Add(m);
  return batch.Solve();
}

}  // namespace tagtwist
