// How a window is solved, and what it learns of noise and motion.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>
#include <utility>

#include "estimator/motion/motion_profile.h"
#include "estimator/motion/open_motion.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/noise_rounds.h"
#include "estimator/window/fixed_lag_smoother.h"

namespace tagtwist::internal {
namespace {

// Weight that a frame's noise statistics keep from one frame to the next: about 300 frames count.
constexpr double kFade = 1.0 - 1.0 / 300;

// A window's frames may not resolve the motion; the likeliest density is then far too small as
// often as not, and what follows from it too sure. Each part's becomes the largest that is nearly
// as likely.
void RaiseWhatIsNotResolved(const EstimatorSetup& setup, const SolveOptions& options,
                            const GraphInput& input, NoiseModel* noise) {
  constexpr double kNearly = 2, kStep = 2;
  constexpr int kMostSteps = 8;
  if (!MotionIsLearned(setup.options)) return;
  const auto start = SolveAndInvert(setup, *noise, input, options);
  if (!start) return;
  for (const auto part : {&NoiseModel::linear, &NoiseModel::angular}) {
    for (int i = 0; i < kMostSteps; ++i) {
      NoiseModel higher = *noise;
      (higher.*part).psd *= kStep;
      const auto there = SolveAndInvert(setup, higher, input, options);
      if (!there || !(there->log_likelihood > start->log_likelihood - kNearly)) break;
      *noise = higher;
    }
  }
}

// What the newest frame's tags say of its pose, as the last solution has it: a step keeps forms of
// them, of which it is the minimum, and which far from where they were made say something else than
// the tags.
std::optional<PoseInformation> InformationOfNewest(const EstimatorSetup& setup,
                                                   const NoiseModel& noise,
                                                   const WindowHypothesis& hypothesis) {
  const GraphFrame& frame = hypothesis.input.frames.back();
  if (!hypothesis.is_step) {
    return InformationOfTags(setup, noise.corner_sigma_px, frame.state.world_from_body, frame.tags);
  }
  const Graph& graph = hypothesis.chain.graph();
  if (graph.states.back().t_ns != frame.t_ns) return std::nullopt;
  const PoseForm& told = hypothesis.chain.form(static_cast<int>(graph.states.size()) - 1);
  if (told.factors.empty()) return std::nullopt;
  const double scale = told.Scale(graph);
  double cost = 0;
  const PoseStep gradient = told.form.GradientAt(graph.states.back().pose, &cost);
  return PoseInformation{scale * told.form.hessian, -scale * gradient};
}

}  // namespace

// Over one frame, or, where the time is up, over several.
Status FixedLagSmoother::LearnAtFirst(const TimeUp& time_up, WindowHypothesis* hypothesis) {
  hypothesis->TakePrior();
  for (GraphFrame& frame : hypothesis->input.frames) frame.motion = MotionScale();
  const auto learned = SolveAndLearn(setup_, StepOptions(time_up), &hypothesis->input, &noise_);
  if (!learned) return learned.error();
  if (!IsUp(time_up) && !HasTracks(setup_, hypothesis->input)) {
    RaiseWhatIsNotResolved(setup_, StepOptions(time_up), hypothesis->input, &noise_);
  }
  hypothesis->motion = HistoryOf(setup_, noise_, hypothesis->input.frames, true);
  LetMotionVary(hypothesis);
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
  if (const auto bent = BendToNewest(time_up, &only); !bent) return bent;
  segmenter_.Reject(ContradictedSegments(only.solution.graph, only.input.segments.size()));
  if (IsUp(time_up) || !DropContradicted(setup_, noise_, &only)) return Ok();
  only.input.segments = segmenter_.segments();
  return SolveOne(time_up, &only);
}

// Tags that agree with one another outrank the motion: it was livelier than anybody knew. Where
// even that does not reconcile them with the frames before, those are at an end.
Status FixedLagSmoother::BendToNewest(const TimeUp& time_up, WindowHypothesis* hypothesis) {
  constexpr int kMostTimes = 3;
  constexpr double kLivelier = 1e3;
  for (int i = 0; i < kMostTimes && NewestContradicts(setup_, noise_, *hypothesis); ++i) {
    MotionScale& motion = hypothesis->input.frames.back().motion;
    motion.linear *= kLivelier;
    motion.angular *= kLivelier;
    if (const auto solved = SolveOne(time_up, hypothesis); !solved) return solved;
  }
  if (NewestContradicts(setup_, noise_, *hypothesis)) {
    return Error{"the tags contradict all that went before"};
  }
  return Ok();
}

Status FixedLagSmoother::SolveOne(const TimeUp& time_up, WindowHypothesis* hypothesis) {
  const bool steps = setup_.options.solver == Solver::kAuto && hypotheses_.size() == 1 &&
                     !HasTracks(setup_, hypothesis->input);
  return steps ? StepHypothesis(setup_, noise_, StepOptions(time_up), hypothesis)
               : SolveHypothesis(setup_, noise_, StepOptions(time_up), hypothesis);
}

// The frames' motion: under the one density that the noise has, or, where what the tags of the
// frames say by themselves contradicts that, of a density of its own in each interval. Several
// accounts of the frames are judged by one motion: else a lively one would excuse everything.
void FixedLagSmoother::FollowMotion() {
  for (WindowHypothesis& hypothesis : hypotheses_) {
    GraphFrame shown = hypothesis.input.frames.back();
    // What is left of tags that contradict one another may be the wrong one.
    if (shown.tags.size() < seen_.back().tags.size() && LoneTag(shown.tags)) shown.tags.clear();
    hypothesis.motion.Add(setup_, noise_, shown);
  }
  if (hypotheses_.size() == 1) LetMotionVary(&hypotheses_[0]);
}

void FixedLagSmoother::LetMotionVary(WindowHypothesis* hypothesis) const {
  if (setup_.options.use_tracks && !segmenter_.segments().empty()) {
    for (GraphFrame& frame : hypothesis->input.frames) frame.motion = MotionScale();
    return;  // the bank knows of no tracks
  }
  const MotionParts varying = VaryingParts(hypothesis->motion, setup_.options);
  if (!varying.linear && !varying.angular) return;
  TakeMotion(hypothesis->motion, noise_, varying, &hypothesis->input.frames);
}

// How lively the motion is at the end shows later: what the bank leaves open counts as far as the
// bank may be right. Variances that are added are independent from entry to entry: far from the
// tags, position and attitude hang together, and scaled ones would make up a combination that is
// surely wrong.
StateVector FixedLagSmoother::ExcessVariances(const WindowHypothesis& hypothesis) const {
  const MotionParts learned = LearnedParts(setup_.options),
                    varying = VaryingParts(hypothesis.motion, setup_.options);
  const MotionHistory::Shares open = hypothesis.motion.ShareOfBank();
  const double linear = varying.linear   ? 1
                        : learned.linear ? open.linear
                                         : 0,
               angular = varying.angular   ? 1
                         : learned.angular ? open.angular
                                           : 0;
  StateVector out = hypothesis.motion.banks().ExcessVariances();
  out.segment<6>(3) *= linear;
  out.head<3>() *= angular;
  out.tail<3>() *= angular;
  return out;
}

// Of the newest state, which has that covariance. Tracks say of its pose what the bank does not
// know, and tags that the bank passes over what it would not take.
StateCovariance FixedLagSmoother::OpenAtArrival(const Block& covariance) const {
  const WindowHypothesis& likeliest = hypotheses_.front();
  const GraphFrame& frame = likeliest.input.frames.back();
  const auto* before = likeliest.motion.LastPrediction();
  const auto tags = before != nullptr && !HasTracks(setup_, likeliest.input)
                        ? InformationOfNewest(setup_, noise_, likeliest)
                        : std::nullopt;
  if (!tags) return ExcessVariances(likeliest).asDiagonal();
  ArrivedState arrived{covariance, *tags, {}, {}};
  const MotionParts learned = LearnedParts(setup_.options);
  const auto prior = [](MotionPrior one, double scale) {
    one.psd *= scale;
    return one;
  };
  if (learned.linear) arrived.linear = prior(noise_.linear, frame.motion.linear);
  if (learned.angular) arrived.angular = prior(noise_.angular, frame.motion.angular);
  const Solution& solution = likeliest.solution;
  const StateCovariance last = OpenMotion(*before, arrived);
  if (hypotheses_.size() > 1) return last;
  return last +
         OpenBeforeTheLast(
             {solution.graph.states, solution.covariance, noise_, SolvedChain::kOfWindow}, learned);
}

void FixedLagSmoother::LearnWhatIsNotFollowed() {
  if (hypotheses_.size() > 1) return;
  const GraphFrame& leaving = hypotheses_.front().input.frames.front();
  const auto shown = ShownBy(setup_, noise_.corner_sigma_px, leaving.t_ns,
                             leaving.state.world_from_body, leaving.tags);
  if (shown) unfollowed_motion_.Add(*shown, LearnedParts(setup_.options));
}

void FixedLagSmoother::LookForOpenMotion(bool at_all) {
  const WindowHypothesis& likeliest = hypotheses_.front();
  if (hypotheses_.size() > 1 || HasTracks(setup_, likeliest.input)) return;
  const Solution& solution = likeliest.solution;
  open_motion_.Look({solution.graph.states, solution.covariance, noise_, SolvedChain::kOfWindow},
                    InSolution(likeliest, 0), LearnedParts(setup_.options), at_all);
}

NoiseStatistics FixedLagSmoother::StatisticsOfLeaving() const {
  const WindowHypothesis& hypothesis = hypotheses_.front();
  const Solution& solution = hypothesis.solution;
  const auto absolute = [](NoiseStatistics statistics, const MotionScale& motion) {
    statistics.linear.sum *= motion.linear;
    statistics.angular.sum *= motion.angular;
    return statistics;
  };
  const std::vector<GraphState>& states = solution.graph.states;
  if (!hypothesis.is_step || states.size() < 2) {
    return absolute(ComputeNoiseStatistics(solution.graph, solution.covariance, noise_, {0, 1}),
                    states.size() > 1 ? states[1].motion : MotionScale());
  }
  // A step keeps no factors: those of the first frame, and of its motion to the next.
  GraphInput two;
  two.frames.assign(hypothesis.input.frames.begin(), hypothesis.input.frames.begin() + 2);
  two.frames[1].tags.clear();
  BlockBandedMatrix covariance(2, 1);
  covariance.At(0, 0) = solution.covariance.At(0, 0);
  covariance.At(1, 0) = solution.covariance.At(1, 0);
  covariance.At(1, 1) = solution.covariance.At(1, 1);
  return absolute(
      ComputeNoiseStatistics(BuildGraph(setup_, noise_, two), covariance, noise_, {0, 1}),
      two.frames[1].motion);
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

SolveOptions FixedLagSmoother::StepOptions(const TimeUp& time_up) const {
  return {setup_.options.window_iterations, 1e-6, time_up};
}

}  // namespace tagtwist::internal
