// What a window tells of its frames, and of those between and after them.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

#include "estimator/graph/pose_bound.h"
#include "estimator/graph/reprojection.h"
#include "estimator/motion/motion_profile.h"
#include "estimator/solve/noise_learning.h"
#include "estimator/start/mirror.h"
#include "estimator/window/fixed_lag_smoother.h"

namespace tagtwist::internal {
namespace {

// Attitudes that lie further apart are open: 5 degrees.
constexpr double kOpenRad = 0.0873;
// What is faster is a contradiction among tags or stamps, and no body's state.
constexpr double kFastestMps = 50;

// A motion that nobody sees may become livelier: within some seconds it is expected to be what a
// body's motion is before anything is known of it.
MotionScale MotionInGap(const MotionScale& before, const NoiseModel& noise,
                        const NoiseModel& at_first, double gap_s) {
  constexpr double kMeanS = 2;
  const double share = 1 - std::exp(-gap_s / kMeanS);
  // Between a mean of densities, by which a lively motion would grow too fast, and one of their
  // logarithms, by which rest would be believed in.
  const auto part = [share](double scale, double at_first_scale) {
    const double root = std::sqrt(scale), first = std::sqrt(at_first_scale);
    const double mixed = root + share * std::max(0.0, first - root);
    return mixed * mixed;
  };
  return {part(before.linear, at_first.linear.psd / noise.linear.psd),
          part(before.angular, at_first.angular.psd / noise.angular.psd)};
}

// Variances of a state, independent of one another, at dt_s later.
StateVector Onward(const StateVector& variances, double dt_s) {
  StateVector out = variances;
  out.head<3>() += dt_s * dt_s * variances.tail<3>();
  out.segment<3>(3) += dt_s * dt_s * variances.segment<3>(6);
  return out;
}

// The body may have been carried to where tags say that do not agree among themselves, which later
// frames tell: until then the covariance is that of a mixture of both.
void Doubt(const Pose& elsewhere, FrameEstimate* out) {
  constexpr double kProbability = 0.1, kOpenRadThere = 0.5;  // it may be the mirrored pose
  constexpr double kOpenShare = 0.3;                         // of the way
  const PoseStep d = Difference(elsewhere, out->state.world_from_body);
  PoseStep open;
  open << Eigen::Vector3d::Constant(kOpenRadThere),
      Eigen::Vector3d::Constant(kOpenShare * d.tail<3>().norm());
  PoseCovariance more = d * d.transpose();
  more.diagonal() += open.cwiseAbs2();
  out->covariance.topLeftCorner<6, 6>() += kProbability * more;
}

// A twist that may be of that moment as well.
void OpenTwist(const StateAndCovariance& other, FrameEstimate* out) {
  const Eigen::Matrix<double, 6, 1> d = Difference(other.state, out->state).tail<6>();
  out->covariance.bottomRightCorner<6, 6>() = other.covariance.bottomRightCorner<6, 6>();
  out->covariance.bottomRightCorner<6, 6>() += d * d.transpose();
}

// The pose as measured, beside a twist that was predicted.
void TakePose(const PoseMeasurement& pose, FrameEstimate* out) {
  out->state.world_from_body = pose.world_from_body;
  out->covariance.topRows<6>().setZero();
  out->covariance.leftCols<6>().setZero();
  out->covariance.block<3, 3>(0, 0) = pose.attitude_covariance;
  out->covariance.block<3, 3>(3, 3) = pose.position_covariance;
  if (out->status == FrameStatus::kPredicted) out->status = FrameStatus::kOk;
}

// Whether the frame's tags may leave a mirrored pose open, by how well they tell the attitude:
// where they are many, to ask would cost more than all else of the frame.
bool MayBeMirrored(const std::optional<PoseCovariance>& bound) {
  constexpr double kSureRad = 0.01;
  return !bound || !(bound->topLeftCorner<3, 3>().trace() < kSureRad * kSureRad);
}

// With its standard deviations multiplied.
StateCovariance Scaled(const StateCovariance& covariance, const StateVector& by) {
  return by.asDiagonal() * covariance * by.asDiagonal();
}

}  // namespace

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

// Of a frame after that state and before the next, if there is one.
FrameEstimate FixedLagSmoother::EstimateOfUnseen(int state, const Unseen& unseen) const {
  const WindowHypothesis& likeliest = hypotheses_.front();
  const Solution& solution = likeliest.solution;
  const int first = InSolution(likeliest, state);
  Trajectory around{{}, {}, {}, noise_.linear, noise_.angular};
  const auto take = [&](int k) {
    around.states.push_back(solution.graph.states[static_cast<size_t>(k)]);
    around.covariances.push_back(solution.covariance.At(k, k));
  };
  take(first);
  double gap_s = ToSeconds(unseen.t_ns - around.states[0].t_ns);
  StateVector more = StateVector::Zero();
  if (first + 1 < solution.covariance.size()) {
    take(first + 1);
    around.cross_covariances.push_back(solution.covariance.At(first + 1, first));
    gap_s = std::min(gap_s, ToSeconds(around.states[1].t_ns - unseen.t_ns));
  } else {
    around.states[0].motion =
        MotionInGap(around.states[0].motion, noise_, InitialNoise(setup_.options), gap_s);
    more = Onward(ExcessVariances(likeliest), gap_s);
  }
  const auto at = around.At(unseen.t_ns);
  FrameEstimate out;
  out.t_ns = unseen.t_ns;
  out.closed_form = unseen.closed_form;
  out.n_tracks = unseen.n_tracks;
  out.status =
      hypotheses_.size() > 1 || IsMirrorOpen() || seen_[static_cast<size_t>(state)].is_doubted
          ? FrameStatus::kNoFix
          : FrameStatus::kPredicted;
  out.state = at->state;
  out.covariance = Scaled(at->covariance, prediction_check_.At(gap_s).OfSigmas());
  out.covariance.diagonal() += more;
  if (unseen.pose) {
    const auto open_ns = static_cast<int64_t>(std::llround(1e9 * unseen.open_s));
    OpenTwist(*around.At(unseen.t_ns + open_ns), &out);
    TakePose(*unseen.pose, &out);
  }
  if (unseen.elsewhere) Doubt(*unseen.elsewhere, &out);
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
  FrameEstimate out =
      ToFrameEstimate(seen_[k].closed_form, seen_[k].n_tracks, frame,
                      BodyCovariance(likeliest.solution.covariance, InSolution(likeliest, state)));
  out.pose_bound = PoseBound(setup_, noise_.corner_sigma_px, out.state.world_from_body, frame.tags);
  const bool leaves = state == 0 && static_cast<int>(seen_.size()) == setup_.options.window_frames;
  if (const double gap_s = GapSeconds(likeliest, state); gap_s > 0) {
    out.covariance = Scaled(out.covariance, prediction_check_.At(gap_s).OfSigmas());
  } else if (leaves && likeliest.is_step) {
    // Densities that follow the motion are not those that the power was found for.
    const MotionParts varying = VaryingParts(likeliest.motion, setup_.options);
    StateVector by = power_.scale();
    if (varying.linear) by.segment<6>(3).setOnes();
    if (varying.angular) by.head<3>().setOnes(), by.tail<3>().setOnes();
    out.covariance = Scaled(out.covariance, by);
  }
  if (state + 1 == static_cast<int>(seen_.size())) {  // how lively it is shows later
    const int last = InSolution(likeliest, state);
    out.covariance += OpenAtArrival(likeliest.solution.covariance.At(last, last));
  } else {
    out.covariance += open_motion_.Of(state);
  }
  out.covariance += unfollowed_motion_.Covariance();
  const bool is_absurd = !(out.state.twist.v_world.norm() < kFastestMps);
  if (IsMirrorOpen() || seen_[k].is_doubted || is_absurd) out.status = FrameStatus::kNoFix;
  if (!frame.tags.empty() && MayBeMirrored(out.pose_bound)) {
    const double doubt = MirrorDoubt(setup_, noise_, likeliest.input.frames);
    TakeMirrored(setup_, likeliest.input.frames, k, doubt, &out.covariance);
  }
  if (hypotheses_.size() > 1) {
    const StateVector d = Difference(hypotheses_[1].input.frames[k].state, frame.state);
    if (d.head<3>().norm() > kOpenRad) out.status = FrameStatus::kNoFix;
    out.covariance += DoubtOf(hypotheses_) * d * d.transpose();
  }
  return out;
}

std::vector<FrameEstimate> FixedLagSmoother::EstimatesOfAll() {
  if (!hypotheses_.empty()) LookForOpenMotion(/*at_all=*/true);
  std::vector<FrameEstimate> out;
  for (size_t i = 0; i < seen_.size(); ++i) Tell(static_cast<int>(i), &out);
  return out;
}

bool FixedLagSmoother::IsMirrorOpen() const {
  return mirror_is_open_ && mirror_angle_rad_ > kOpenRad;
}

// What the tags of a frame say whose stamp cannot be.
std::optional<PoseMeasurement> FixedLagSmoother::PoseOutOfTime(
    const FrameMeasurements& measurement) const {
  const GraphFrame& last = hypotheses_[0].input.frames.back();
  const FrameStarts starts = StartFrame(setup_, noise_, measurement, &last, std::nullopt);
  if (starts.starts.empty()) return std::nullopt;
  const GraphFrame& frame = starts.starts[0];
  return PoseOfTags(setup_, noise_.corner_sigma_px, frame.tags, frame.state.world_from_body);
}

// A frame that says nothing of the motion is predicted, until that is worth nothing.
void FixedLagSmoother::AddUnseen(const Unseen& unseen, const FrameMeasurements& measurement,
                                 WindowOutput* out) {
  constexpr double kLostRad = 1, kLostM = 10;  // standard deviations of an axis

  out->current = WithoutState(measurement);
  if (!hypotheses_.empty()) {
    const int newest = static_cast<int>(seen_.size()) - 1;
    out->current = EstimateOfUnseen(newest, unseen);
    const StateVector variances = out->current.covariance.diagonal();
    const bool is_lost = !(variances.head<3>().maxCoeff() < kLostRad * kLostRad &&
                           variances.segment<3>(3).maxCoeff() < kLostM * kLostM &&
                           out->current.state.twist.v_world.norm() < kFastestMps);
    if (is_lost) {
      LeaveAll(out);
      out->current = WithoutState(measurement);
    }
  }
  if (hypotheses_.empty() || seen_.back().is_told) {
    out->lagged.push_back(out->current);
    return;
  }
  seen_.back().after.push_back(unseen);
  if (static_cast<int>(seen_.back().after.size()) > setup_.options.window_frames) {
    TellBeforeTheGapEnds(out);
  }
}

// What the frames of the window, and those since, are known to be: nothing refines them any more
// soon, and what waits must not grow.
void FixedLagSmoother::TellBeforeTheGapEnds(WindowOutput* out) {
  for (size_t i = 0; i < seen_.size(); ++i) {
    Tell(static_cast<int>(i), &out->lagged);
    seen_[i].after.clear();
    seen_[i].is_told = true;
  }
}

// A frame of the window, and those until the next one, as they are known.
void FixedLagSmoother::Tell(int state, std::vector<FrameEstimate>* out) const {
  const Seen& seen = seen_[static_cast<size_t>(state)];
  if (seen.is_told) return;
  out->push_back(EstimateOf(state));
  for (const Unseen& unseen : seen.after) out->push_back(EstimateOfUnseen(state, unseen));
}

}  // namespace tagtwist::internal
