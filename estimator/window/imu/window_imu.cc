#include "estimator/window/imu/window_imu.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/graph/marginalisation.h"
#include "estimator/graph/reprojection.h"
#include "estimator/result/imu_left_out.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/steady_clock.h"

namespace tagtwist::internal {
namespace {

Block InformationOf(const Block& covariance) {
  Block wide = covariance;
  wide.diagonal() *= 1 + 1e-9;
  const Block information = wide.ldlt().solve(Block::Identity());
  return 0.5 * (information + information.transpose());
}

}  // namespace

WindowImu::WindowImu(EstimatorSetup setup, const ImuOptions& options)
    : setup_(std::move(setup)),
      options_(options),
      learning_(options),
      bias_covariance_(Block::Zero()) {
  setup_.options.use_tracks = false;
}

void WindowImu::AddSamples(const std::vector<ImuSample>& samples) {
  for (const ImuSample& sample : samples) {
    if (learning_.goes_on()) learning_.Add(sample);
    samples_.push_back(sample);
    if (model_) in_body_.push_back(InBody(sample, model_->calibration));
  }
}

void WindowImu::AddTo(const FrameMeasurements& measurement, const NoiseModel& noise,
                      WindowOutput* out) {
  const bool has_tags_state = out->current.status == FrameStatus::kOk;
  if (auto learned = learning_.Add(setup_, noise, measurement, *out)) {
    BeginLearned(std::move(*learned), noise);
  }
  if (!frames_.empty()) {
    const bool is_longer = Extend(measurement, noise, out->used_tags);
    if (is_longer && (IsUseless() || Contradicts(noise))) {
      frames_.pop_back();  // it is not told
      End();
    } else if (!is_longer) {
      End();
    }
  }
  if (model_) in_body_ = InBody(samples_, model_->calibration);
  if (frames_.empty() && model_ && has_tags_state) {
    BeginFromTags(out->current, TagsOfState(measurement, *out), noise);
  }
  TakeInto(&at_arrival_, &out->current);
  AddTo(&out->lagged);
  if (static_cast<int>(frames_.size()) > setup_.options.window_frames) LetOldestLeave();
  DropOldSamples();
}

void WindowImu::AddTo(std::vector<FrameEstimate>* lagged) {
  for (FrameEstimate& frame : *lagged) TakeInto(&at_lag_, &frame);
  if (lagged->empty()) return;
  while (!left_.empty() && left_.front().t_ns <= lagged->back().t_ns) left_.pop_front();
}

// The newest of the frames that it was learned from begins a chain with all that was; the IMU
// carries it on to the frame that is there by now.
void WindowImu::BeginLearned(ImuSolution solved, const NoiseModel& noise) {
  End();
  model_ = solved.model;
  found_ = solved.found;
  in_body_ = InBody(samples_, model_->calibration);
  const int last = solved.solution.covariance.size() - 1;
  CalibratedState known{model_->calibration, solved.calibration_covariance,
                        solved.solution.covariance.At(last, last)};
  for (int i = 0; i < kImuEntries; ++i) {
    known.by_calibration.col(i) = solved.shared_errors[static_cast<size_t>(i)].tail<kBlockSize>();
  }
  Begin(solved.input.frames.back(), known.given_calibration, noise);
  border_ = CalibrationBorder(known, chain_.graph().states.front());
  covariance_.At(0, 0) += known.by_calibration * known.by_calibration.transpose();
}

// As it is now, for samples to come.
void WindowImu::TakeCalibration() {
  model_->calibration = border_.calibration();
  const ImuStep sigmas = border_.covariance().diagonal().cwiseMax(0).cwiseSqrt();
  found_->gravity_world_mps2 = model_->calibration.gravity_world_mps2;
  found_->gravity_sigma_rad = sigmas.head<2>().maxCoeff();
  found_->time_offset_s = model_->calibration.time_offset_s;
  found_->time_offset_sigma_s = sigmas(2);
  const Pose& place = model_->calibration.body_from_imu;
  found_->mount_rad = Difference(place, options_.body_from_imu).head<3>();
  found_->mount_sigma_rad = sigmas.segment<3>(3);
  found_->imu_in_body_m = place.translation();
  found_->imu_in_body_sigma_m = sigmas.tail<3>();
}

// A chain of a frame whose state and covariance have all that is known of it.
void WindowImu::Begin(const GraphFrame& frame, const Block& covariance, const NoiseModel& noise) {
  GraphInput input;
  input.frames = {frame};
  input.frames[0].tags.clear();
  input.frames[0].others.clear();
  chain_ = QuadraticChain(BuildWholeGraph(setup_, WithImu(noise), input), InOneRange,
                          CalibrationBorder::kTangent);
  chain_.SetPrior(InformationOf(covariance));
  covariance_ = BlockBandedMatrix(1, 1);
  covariance_.At(0, 0) = covariance;
  frames_ = {frame};
}

void WindowImu::BeginFromTags(const FrameEstimate& by_tags, std::vector<TagDetection> tags,
                              const NoiseModel& noise) {
  GraphFrame frame;
  frame.tags = std::move(tags);
  frame.t_ns = by_tags.t_ns;
  frame.state = by_tags.state;
  frame.acceleration = biases_;
  Block covariance = bias_covariance_;
  covariance.topLeftCorner<12, 12>() = by_tags.covariance;
  Begin(frame, covariance, noise);
  border_.Restart();
}

// Up to a frame that is a little newer than the newest sample, by whatever clock, as that one says.
void WindowImu::HoldUntil(int64_t t_ns) {
  constexpr double kMostS = 0.025;
  if (in_body_.empty() || in_body_.back().t_ns >= t_ns) return;
  if (ToSeconds(t_ns - in_body_.back().t_ns) > kMostS) return;
  in_body_.push_back(in_body_.back());
  in_body_.back().t_ns = t_ns;
}

// The frame as the chain's next one; false where the IMU does not reach it.
bool WindowImu::Extend(const FrameMeasurements& measurement, const NoiseModel& noise,
                       const std::vector<int>& used) {
  HoldUntil(measurement.t_ns);
  const GraphFrame& before = frames_.back();
  const ImuBias bias = BiasOf(before.acceleration);
  const ImuNoise white = NoiseOf(options_, model_->scale);
  const auto motion =
      Preintegrate(in_body_, before.t_ns, measurement.t_ns, bias, white, kLongestImuStepS);
  if (!motion) return false;
  GraphFrame frame;
  frame.t_ns = measurement.t_ns;
  frame.state = CarryOn(before.state, *motion, model_->calibration,
                        RateAt(in_body_, frame.t_ns, bias).value_or(before.state.twist.omega_body));
  frame.acceleration = before.acceleration;
  const auto predicted = PredictAt(measurement.t_ns);
  Block spread = Block::Zero();
  if (predicted) spread.topLeftCorner<12, 12>() = predicted->covariance;
  frame.tags = TagsNear(frame, spread, measurement.tags, used);
  SetImuFactors(in_body_, options_, *model_, &before, &frame);
  chain_.AddState(ToGraphState(frame.t_ns, frame.state, frame.acceleration, frame.motion));
  const int newest = static_cast<int>(frames_.size());
  chain_.AddFactors(FactorsOfFrame(setup_, WithImu(noise), frame, chain_.graph(), newest));
  frames_.push_back(std::move(frame));
  constexpr ChainRules kRules{1e-3, true};
  auto solved = chain_.Solve({setup_.options.window_iterations, 1e-6}, kRules);
  if (!solved) return false;
  covariance_ = std::move(solved->covariance);
  TakeStates(chain_.graph(), &frames_);
  if (!border_.Update(&chain_, &covariance_, &frames_)) return false;
  TakeCalibration();
  return true;
}

// Its states go on being told, as they are.
void WindowImu::End() {
  if (frames_.empty()) return;
  const int last = std::min(covariance_.size(), static_cast<int>(frames_.size())) - 1;
  if (last >= 0) {
    biases_ = frames_[static_cast<size_t>(last)].acceleration;
    bias_covariance_.setZero();
    bias_covariance_.bottomRightCorner<6, 6>() =
        covariance_.At(last, last).bottomRightCorner<6, 6>();
  }
  for (size_t k = 0; k < frames_.size() && static_cast<int>(k) <= last; ++k) {
    const auto i = static_cast<int>(k);
    if (!left_.empty() && left_.back().t_ns >= frames_[k].t_ns) continue;
    left_.push_back({frames_[k].t_ns, frames_[k].state, BodyCovariance(covariance_, i),
                     !frames_[k].tags.empty()});
  }
  frames_.clear();
  chain_ = QuadraticChain();
  covariance_ = BlockBandedMatrix(0, 0);
}

void WindowImu::LetOldestLeave() {
  left_.push_back({frames_[0].t_ns, frames_[0].state, BodyCovariance(covariance_, 0),
                   !frames_[0].tags.empty()});
  border_.MarginalizeFirst(chain_);
  chain_.MarginalizeFirst();
  frames_.erase(frames_.begin());
  BlockBandedMatrix rest(covariance_.size() - 1, covariance_.bandwidth());
  for (int k = 0; k < rest.size(); ++k) rest.At(k, k) = covariance_.At(k + 1, k + 1);
  covariance_ = std::move(rest);
}

void WindowImu::TakeInto(SurerStates* surer, FrameEstimate* frame) const {
  const auto take = [&](const BodyState& state, const StateCovariance& covariance, bool has_tags) {
    FrameEstimate by_both = *frame;
    by_both.state = state;
    by_both.covariance = covariance;
    const bool are_by_tags = surer->Choose(*frame, &by_both);
    *frame = std::move(by_both);
    if (are_by_tags) return;
    if (!has_tags) frame->status = FrameStatus::kPredicted;
    if (has_tags && frame->status != FrameStatus::kHurried) frame->status = FrameStatus::kOk;
  };
  for (size_t k = 0; k < frames_.size(); ++k) {
    if (frames_[k].t_ns != frame->t_ns || static_cast<int>(k) >= covariance_.size()) continue;
    take(frames_[k].state, BodyCovariance(covariance_, static_cast<int>(k)),
         !frames_[k].tags.empty());
    return;
  }
  for (const Left& left : left_) {
    if (left.t_ns == frame->t_ns) take(left.state, left.covariance, left.has_tags);
  }
}

void WindowImu::DropOldSamples() {
  if (samples_.empty()) return;
  constexpr int64_t kAroundNs = 200'000'000, kWaitNs = 2'000'000'000;
  int64_t needed_ns = samples_.back().t_ns - kWaitNs;
  if (!frames_.empty()) {
    // By the samples' own clock.
    const double offset_s = model_->calibration.time_offset_s;
    const int64_t first_ns = frames_.front().t_ns + std::llround(1e9 * offset_s) - kAroundNs;
    needed_ns = learning_.goes_on() ? std::min(needed_ns, first_ns) : first_ns;
  }
  const auto old = std::find_if(samples_.begin(), samples_.end(),
                                [&](const ImuSample& sample) { return sample.t_ns >= needed_ns; });
  constexpr std::ptrdiff_t kWorthIt = 50;
  if (old - samples_.begin() <= kWorthIt) return;
  if (model_) in_body_.erase(in_body_.begin(), in_body_.begin() + (old - samples_.begin()));
  samples_.erase(samples_.begin(), old);
}

std::optional<std::string> WindowImu::Warning() const {
  if (model_) return std::nullopt;
  return ImuLeftOut(learning_.refusal());
}

}  // namespace tagtwist::internal
