#include "estimator/sliding_window.h"

#include <algorithm>
#include <utility>

#include "estimator/bound.h"
#include "estimator/marginalisation.h"
#include "estimator/seeding.h"

namespace tagtwist {
namespace {

// Weight that a frame's noise statistics keep from one frame to the next: about 300 frames count.
constexpr double kFade = 1.0 - 1.0 / 300;

double MedianError(const EstimatorSetup& setup, const GraphFrame& frame) {
  std::vector<double> errors = ReprojectionErrors(setup, frame);
  if (errors.empty()) return 1e9;
  std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(errors.size() / 2),
                   errors.end());
  return errors[errors.size() / 2];
}

}  // namespace

SlidingWindow::SlidingWindow(EstimatorSetup setup)
    : setup_(std::move(setup)),
      noise_(InitialNoise(setup_.options)),
      segmenter_({setup_.options.max_tracks_per_frame, setup_.options.track_segment_frames}) {}

std::optional<GraphFrame> SlidingWindow::MakeFrame(const FrameMeasurements& measurement) const {
  GraphFrame frame;
  frame.t_ns = measurement.t_ns;
  const bool first = input_.frames.empty();
  if (!first) {
    const GraphFrame& last = input_.frames.back();
    frame.state = Predict(last.state, ToSeconds(frame.t_ns - last.t_ns));
    frame.acceleration = last.acceleration;
  } else if (measurement.closed_form.twist_ransac) {
    frame.state.twist = *measurement.closed_form.twist_ransac;
  }
  const PoseSeed seed = SeedPose(measurement.tags, setup_.map, setup_.camera, setup_.cam_from_body);
  frame.tags = AgreeingTags(measurement.tags, seed);
  const auto pose = ChoosePose(seed, first ? nullptr : &frame.state.world_from_body);
  if (first && !pose) return std::nullopt;
  if (pose) {
    // The prediction is the better start while it is near; after a gap the tags are.
    constexpr double kFarPx = 5.0;
    if (first || !(MedianError(setup_, frame) < kFarPx)) frame.state.world_from_body = *pose;
  }
  return frame;
}

Status SlidingWindow::SolveWindow() {
  input_.segments = segmenter_.segments();
  const SolveOptions options{setup_.options.window_iterations, 1e-6};
  const bool full = static_cast<int>(input_.frames.size()) == setup_.options.window_frames;
  const bool learn = full && !has_learned_;
  auto solution = learn ? SolveAndLearn(setup_, options, &input_, &noise_)
                        : SolveAndInvert(setup_, noise_, input_, options);
  if (!solution) return solution.error();
  has_learned_ = has_learned_ || learn;
  TakeStates(solution->graph, &input_.frames);
  solution_ = std::move(*solution);
  return Ok();
}

bool SlidingWindow::DropContradicted() {
  if (!has_learned_) return false;  // the noise is a guess yet
  segmenter_.Reject(ContradictedSegments(solution_->graph, input_.segments.size()));
  const std::vector<TagRef> wrong = ContradictedTags(solution_->graph);
  size_t n_newest = 0;
  const int newest = static_cast<int>(input_.frames.size()) - 1;
  for (const TagRef& ref : wrong) n_newest += ref.state == newest ? 1 : 0;
  // Where most tags of the newest frame disagree, its state is wrong rather than they.
  if (2 * n_newest > input_.frames.back().tags.size()) return false;
  DropTags(wrong, &input_.frames);
  return !wrong.empty();
}

FrameEstimate SlidingWindow::EstimateOf(int state) const {
  const GraphFrame& frame = input_.frames[static_cast<size_t>(state)];
  FrameEstimate out = ToFrameEstimate(closed_forms_[static_cast<size_t>(state)],
                                      n_tracks_[static_cast<size_t>(state)], frame,
                                      BodyCovariance(solution_->covariance, state));
  out.pose_bound = PoseBound(setup_, noise_.corner_sigma_px, out.state.world_from_body, frame.tags);
  return out;
}

void SlidingWindow::LearnFromLeavingState() {
  statistics_ = statistics_ * kFade;
  statistics_ += ComputeNoiseStatistics(solution_->graph, solution_->covariance, noise_, {0, 1});
  noise_ = UpdateNoise(noise_, statistics_, setup_.options);
}

void SlidingWindow::MarginalizeOldest() {
  input_.prior = MarginalizeFirstState(solution_->graph);
  audit_.Add(setup_, input_.frames.front(), seen_.front());
  input_.frames.erase(input_.frames.begin());
  seen_.erase(seen_.begin());
  closed_forms_.erase(closed_forms_.begin());
  n_tracks_.erase(n_tracks_.begin());
  ++input_.first_frame;
  segmenter_.DropBefore(input_.first_frame);
}

Result<WindowOutput> SlidingWindow::Add(const FrameMeasurements& measurement) {
  WindowOutput out;
  segmenter_.Add(measurement.tracks, static_cast<int>(measurement.tags.size()));
  const int n_tracks = static_cast<int>(measurement.tracks.size());
  auto frame = MakeFrame(measurement);
  if (!frame) {
    ++input_.first_frame;
    segmenter_.DropBefore(input_.first_frame);
    out.current = ToFrameEstimate(measurement.closed_form, n_tracks, {}, StateCovariance::Zero());
    out.current.t_ns = measurement.t_ns;
    out.current.status = FrameStatus::kNoFix;
    return out;
  }
  input_.frames.push_back(std::move(*frame));
  seen_.push_back(measurement.tags);
  closed_forms_.push_back(measurement.closed_form);
  n_tracks_.push_back(n_tracks);
  if (const auto solved = SolveWindow(); !solved) return solved.error();
  if (DropContradicted()) {
    if (const auto solved = SolveWindow(); !solved) return solved.error();
  }

  const int newest = static_cast<int>(input_.frames.size()) - 1;
  out.current = EstimateOf(newest);
  out.reprojection_px = ReprojectionErrors(setup_, input_.frames.back());
  if (newest + 1 == setup_.options.window_frames) {
    out.lagged = EstimateOf(0);
    LearnFromLeavingState();
    MarginalizeOldest();
  }
  return out;
}

std::optional<StateAndCovariance> SlidingWindow::PredictAt(int64_t t_ns) const {
  if (!solution_) return std::nullopt;
  const int newest = static_cast<int>(solution_->graph.states.size()) - 1;
  Trajectory trajectory;
  trajectory.states = {solution_->graph.states.back()};
  trajectory.covariances = {solution_->covariance.At(newest, newest)};
  trajectory.linear = noise_.linear;
  trajectory.angular = noise_.angular;
  return trajectory.At(t_ns);
}

std::vector<FrameEstimate> SlidingWindow::Finish() {
  std::vector<FrameEstimate> out;
  if (input_.frames.empty()) return out;
  // The last step stopped where it was good enough for a new frame; this one may take its time.
  auto solution =
      SolveAndInvert(setup_, noise_, input_, SolveOptions{setup_.options.max_iterations});
  if (!solution) return out;
  TakeStates(solution->graph, &input_.frames);
  solution_ = std::move(*solution);
  for (size_t i = 0; i < input_.frames.size(); ++i) {
    out.push_back(EstimateOf(static_cast<int>(i)));
    audit_.Add(setup_, input_.frames[i], seen_[i]);
  }
  return out;
}

}  // namespace tagtwist
