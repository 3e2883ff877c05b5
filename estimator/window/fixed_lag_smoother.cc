#include "estimator/window/fixed_lag_smoother.h"

#include <algorithm>
#include <cstdlib>
#include <utility>

#include "estimator/graph/pose_bound.h"
#include "estimator/graph/reprojection.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/start/mirror.h"

namespace tagtwist {
namespace {

// Weight that a frame's noise statistics keep from one frame to the next: about 300 frames count.
constexpr double kFade = 1.0 - 1.0 / 300;

// With its standard deviations multiplied.
StateCovariance Scaled(const StateCovariance& p, const StateVector& by) {
  return by.asDiagonal() * p * by.asDiagonal();
}

}  // namespace

FixedLagSmoother::FixedLagSmoother(EstimatorSetup setup)
    : setup_(std::move(setup)),
      set_up_check_(setup_.map, setup_.camera),
      gate_(setup_.map, setup_.camera),
      noise_(InitialNoise(setup_.options)),
      segmenter_({setup_.options.max_tracks_per_frame, setup_.options.track_segment_frames}) {}

Result<WindowOutput> FixedLagSmoother::Add(const FrameMeasurements& given, const TimeUp& time_up) {
  if (const auto fine = set_up_check_.Add(given.tags); !fine) return fine.error();
  FrameMeasurements measurement = given;
  gate_.TakeRefused(&measurement.tags);
  // Fewer frames know too little of the motion to exclude a pose.
  constexpr size_t kFramesToRelyOn = 5;
  WindowOutput out;
  segmenter_.Add(measurement.tracks, static_cast<int>(measurement.tags.size()));
  std::optional<StateAndCovariance> predicted;
  if (seen_.size() >= kFramesToRelyOn) predicted = PredictAt(measurement.t_ns);
  const GraphFrame* last = hypotheses_.empty() ? nullptr : &hypotheses_[0].input.frames.back();
  FrameStarts starts = StartFrame(setup_, noise_, measurement, last, predicted);
  if (other_place_.Add(starts.excluded, measurement)) {
    out.lagged = EstimatesOfAll();
    Break();
    starts = StartFrame(setup_, noise_, measurement, nullptr, std::nullopt);
  }
  if (starts.starts.empty()) {
    segmenter_.DropBefore(++first_frame_);
    out.current = WithoutState(measurement);
    out.lagged.push_back(out.current);
    return out;
  }
  AddFrame(measurement, starts);
  seen_.back().tags = given.tags;
  if (!SolveAll(time_up) && !StartAnew(measurement, given.tags, time_up, &out)) return out;
  const bool hurried = measurement.cut_short || IsUp(time_up);
  CompareWithMirroredPoses();
  const int newest = static_cast<int>(seen_.size()) - 1;
  out.current = EstimateOf(newest);
  if (hurried && out.current.status == FrameStatus::kOk) {
    out.current.status = FrameStatus::kHurried;
  }
  if (out.current.status != FrameStatus::kNoFix) {
    out.reprojection_px = ReprojectionErrors(setup_, hypotheses_[0].input.frames.back());
  }
  told_.push_back(out.current);
  if (newest + 1 == setup_.options.window_frames) {
    out.lagged.push_back(EstimateOf(0));
    LetTheOldestLeave();
  }
  return out;
}

void FixedLagSmoother::AddFrame(const FrameMeasurements& measurement, const FrameStarts& starts) {
  seen_.push_back(
      {measurement.closed_form, static_cast<int>(measurement.tracks.size()), measurement.tags});
  if (hypotheses_.size() > 1) {  // each goes on by itself
    for (WindowHypothesis& hypothesis : hypotheses_) {
      std::vector<GraphFrame>& frames = hypothesis.input.frames;
      const FrameStarts own = StartFrame(setup_, noise_, measurement, &frames.back(), std::nullopt);
      frames.push_back(own.starts.front());
    }
    return;
  }
  constexpr size_t kMost = 3;
  if (hypotheses_.empty()) hypotheses_.emplace_back();
  const size_t n = std::min(kMost, starts.starts.size());
  while (hypotheses_.size() < n) hypotheses_.push_back(hypotheses_.front());
  for (size_t i = 0; i < hypotheses_.size(); ++i) {
    hypotheses_[i].input.frames.push_back(starts.starts[i]);
  }
}

SolveOptions FixedLagSmoother::StepOptions(const TimeUp& time_up) const {
  return {setup_.options.window_iterations, 1e-6, time_up};
}

// Over one frame, or, where the time is up, over several.
Status FixedLagSmoother::LearnAtFirst(const TimeUp& time_up, WindowHypothesis* hypothesis) {
  hypothesis->TakePrior();
  const auto learned = SolveAndLearn(setup_, StepOptions(time_up), &hypothesis->input, &noise_);
  if (!learned) return learned.error();
  constexpr int kMostFrames = 20;
  has_learned_ = !IsUp(time_up) || ++frames_of_learning_ == kMostFrames;
  return Ok();
}

Status FixedLagSmoother::SolveAll(const TimeUp& time_up) {
  const bool full = static_cast<int>(seen_.size()) == setup_.options.window_frames;
  for (WindowHypothesis& hypothesis : hypotheses_) {
    hypothesis.input.first_frame = first_frame_;
    hypothesis.input.segments = segmenter_.segments();
    if (full && !has_learned_) {  // from the likeliest so far
      if (const auto learned = LearnAtFirst(time_up, &hypothesis); !learned) return learned;
    }
    const auto solved = SolveOne(time_up, &hypothesis);
    if (!solved) return solved;
  }
  Prune(&hypotheses_);
  // Before the noise is known nothing contradicts; nor while it is open who is right.
  if (!has_learned_ || hypotheses_.size() > 1) return Ok();
  WindowHypothesis& only = hypotheses_.front();
  segmenter_.Reject(ContradictedSegments(only.solution.graph, only.input.segments.size()));
  if (IsUp(time_up) || !DropContradicted(&only)) return Ok();
  only.input.segments = segmenter_.segments();
  return SolveOne(time_up, &only);
}

Status FixedLagSmoother::SolveOne(const TimeUp& time_up, WindowHypothesis* hypothesis) {
  const bool steps = setup_.options.solver == Solver::kAuto && hypotheses_.size() == 1 &&
                     !HasTracks(setup_, hypothesis->input);
  return steps ? StepHypothesis(setup_, noise_, StepOptions(time_up), hypothesis)
               : SolveHypothesis(setup_, noise_, StepOptions(time_up), hypothesis);
}

void FixedLagSmoother::CompareWithMirroredPoses() {
  if (!mirror_is_open_) return;
  double cost = mirror_cost_of_left_;
  mirror_angle_rad_ = 0;
  for (const GraphFrame& frame : hypotheses_.front().input.frames) {
    const auto mirror = MirrorOf(setup_, noise_, frame);
    if (!mirror) continue;
    cost += mirror->cost;
    mirror_angle_rad_ = std::max(mirror_angle_rad_, mirror->angle_rad);
  }
  mirror_is_open_ = cost < kDecidedCost;
}

std::optional<StateAndCovariance> FixedLagSmoother::PredictAt(int64_t t_ns) const {
  if (hypotheses_.size() != 1) return std::nullopt;
  const Solution& solution = hypotheses_.front().solution;
  const int newest = static_cast<int>(seen_.size()) - 1, last = solution.covariance.size() - 1;
  const Trajectory onward{{solution.graph.states.back()},
                          {solution.covariance.At(last, last)},
                          {},
                          noise_.linear,
                          noise_.angular};
  auto out = onward.At(t_ns);
  // Over a frame or two the prior is what was learned; what is found beyond is for gaps.
  if (const double gap_s = GapSeconds(hypotheses_.front(), newest); gap_s > 0) {
    const double ahead_s = ToSeconds(t_ns - solution.graph.states.back().t_ns);
    const StateVector by = prediction_check_.At(gap_s + ahead_s).OfSigmas();
    out->covariance = Scaled(out->covariance, by);
  }
  return out;
}

// From a state to the nearest one with tags.
double FixedLagSmoother::GapSeconds(const WindowHypothesis& hypothesis, int state) const {
  const std::vector<GraphFrame>& frames = hypothesis.input.frames;
  const int64_t t_ns = frames[static_cast<size_t>(state)].t_ns;
  std::optional<int64_t> gap_ns;
  if (last_tag_ns_) gap_ns = t_ns - *last_tag_ns_;
  for (const GraphFrame& frame : frames) {
    const int64_t distance_ns = std::abs(frame.t_ns - t_ns);
    if (!frame.tags.empty() && (!gap_ns || distance_ns < *gap_ns)) gap_ns = distance_ns;
  }
  return gap_ns ? ToSeconds(*gap_ns) : 0;
}

FrameEstimate FixedLagSmoother::EstimateOf(int state) const {
  const auto k = static_cast<size_t>(state);
  const WindowHypothesis& likeliest = hypotheses_.front();
  const GraphFrame& frame = likeliest.input.frames[k];
  // The last solution may still hold the state that left.
  const BlockBandedMatrix& covariance = likeliest.solution.covariance;
  const int in_solution = state + covariance.size() - static_cast<int>(seen_.size());
  FrameEstimate out = ToFrameEstimate(seen_[k].closed_form, seen_[k].n_tracks, frame,
                                      BodyCovariance(covariance, in_solution));
  out.pose_bound = PoseBound(setup_, noise_.corner_sigma_px, out.state.world_from_body, frame.tags);
  const bool leaves = state == 0 && static_cast<int>(seen_.size()) == setup_.options.window_frames;
  if (const double gap_s = GapSeconds(likeliest, state); gap_s > 0) {
    out.covariance = Scaled(out.covariance, prediction_check_.At(gap_s).OfSigmas());
  } else if (leaves && likeliest.is_step) {
    out.covariance = Scaled(out.covariance, power_.scale());
  }
  constexpr double kOpenRad = 0.0873;  // 5 degrees
  if (mirror_is_open_ && mirror_angle_rad_ > kOpenRad) out.status = FrameStatus::kNoFix;
  if (hypotheses_.size() > 1) {
    const StateVector d = Difference(hypotheses_[1].input.frames[k].state, frame.state);
    if (d.head<3>().norm() > kOpenRad) out.status = FrameStatus::kNoFix;
    out.covariance += DoubtOf(hypotheses_) * d * d.transpose();
  }
  return out;
}

std::vector<FrameEstimate> FixedLagSmoother::EstimatesOfAll() const {
  std::vector<FrameEstimate> out;
  for (size_t i = 0; i < seen_.size(); ++i) out.push_back(EstimateOf(static_cast<int>(i)));
  return out;
}

NoiseStatistics FixedLagSmoother::StatisticsOfLeaving() const {
  const WindowHypothesis& hypothesis = hypotheses_.front();
  const Solution& solution = hypothesis.solution;
  if (!hypothesis.is_step || solution.graph.states.size() < 2) {
    return ComputeNoiseStatistics(solution.graph, solution.covariance, noise_, {0, 1});
  }
  // A step keeps no factors: those of the first frame, and of its motion to the next.
  GraphInput two;
  two.frames.assign(hypothesis.input.frames.begin(), hypothesis.input.frames.begin() + 2);
  two.frames[1].tags.clear();
  BlockBandedMatrix covariance(2, 1);
  covariance.At(0, 0) = solution.covariance.At(0, 0);
  covariance.At(1, 0) = solution.covariance.At(1, 0);
  covariance.At(1, 1) = solution.covariance.At(1, 1);
  return ComputeNoiseStatistics(BuildGraph(setup_, noise_, two), covariance, noise_, {0, 1});
}

void FixedLagSmoother::LearnFromLeavingState() {
  const Solution& solution = hypotheses_.front().solution;
  if (GapSeconds(hypotheses_.front(), 0) == 0) {
    prediction_check_.Add(solution.graph.states.front(), solution.covariance.At(0, 0),
                          noise_.linear, noise_.angular);
  }
  statistics_ = statistics_ * kFade;
  statistics_ += StatisticsOfLeaving();
  noise_ = UpdateNoise(noise_, statistics_, setup_.options);
  if (!MotionIsLearned(setup_.options)) return;
  if (hypotheses_.front().is_step) {
    power_.Add(setup_, noise_, hypotheses_.front().input.frames);
  } else {  // the power knows of no tracks
    power_.Break();
  }
}

void FixedLagSmoother::LetTheOldestLeave() {
  LearnFromLeavingState();
  if (mirror_is_open_) {
    const auto mirror = MirrorOf(setup_, noise_, hypotheses_.front().input.frames.front());
    if (mirror) mirror_cost_of_left_ += mirror->cost;
  }
  Forget(1);
  for (WindowHypothesis& hypothesis : hypotheses_) MarginalizeOldest(&hypothesis);
}

// The first frames are out of the window; what they saw is taken note of.
void FixedLagSmoother::Forget(size_t n_frames) {
  for (size_t i = 0; i < n_frames; ++i) {
    const GraphFrame& frame = hypotheses_.front().input.frames[i];
    audit_.Add(setup_, frame, seen_[i].tags);
    reprojection_.Add(setup_.camera, setup_.map, frame.t_ns,
                      setup_.cam_from_body * Inverse(frame.state.world_from_body), frame.tags);
    if (!frame.tags.empty()) last_tag_ns_ = frame.t_ns;
  }
  const auto n = static_cast<std::ptrdiff_t>(n_frames);
  seen_.erase(seen_.begin(), seen_.begin() + n);
  told_.erase(told_.begin(), told_.begin() + n);
  first_frame_ += static_cast<int>(n_frames);
  segmenter_.DropBefore(first_frame_);
}

std::vector<std::string> FixedLagSmoother::Warnings() const {
  std::vector<std::string> out = audit_.Warnings();
  if (const auto of_tracks = segmenter_.tally().Warning()) out.push_back(*of_tracks);
  if (const auto of_breaks = RestartWarning()) out.push_back(*of_breaks);
  return out;
}

std::vector<FrameEstimate> FixedLagSmoother::Finish() {
  if (hypotheses_.empty()) return {};
  // The last step stopped where it was good enough for a new frame; this one may take its time.
  const SolveOptions options{setup_.options.max_iterations};
  for (WindowHypothesis& hypothesis : hypotheses_) {
    // An error leaves the last step's solution.
    static_cast<void>(SolveHypothesis(setup_, noise_, options, &hypothesis));
  }
  Prune(&hypotheses_);
  std::vector<FrameEstimate> out = EstimatesOfAll();
  Forget(seen_.size());
  hypotheses_.clear();
  return out;
}

}  // namespace tagtwist
