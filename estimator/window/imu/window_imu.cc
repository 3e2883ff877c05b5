#include "estimator/window/imu/window_imu.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/graph/marginalisation.h"
#include "estimator/graph/reprojection.h"
#include "estimator/solve/contradictions.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/steady_clock.h"

namespace tagtwist::internal {
namespace {

bool IsAmong(int id, const std::vector<int>& ids) {
  return std::find(ids.begin(), ids.end(), id) != ids.end();
}

// A prior on one state, of that covariance.
Factor PriorOn(const GraphState& state, const Block& covariance) {
  Block wide = covariance;
  wide.diagonal() *= 1 + 1e-9;
  const Block information = wide.ldlt().solve(Block::Identity());
  return GaussianPrior({state}, 0.5 * (information + information.transpose()),
                       Eigen::VectorXd::Zero(information.rows()));
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
    if (model_) in_body_.push_back(InBody(sample, model_->calibration));
  }
}

void WindowImu::AddTo(const FrameMeasurements& measurement, const NoiseModel& noise,
                      WindowOutput* out) {
  const bool has_tags_state = out->current.status == FrameStatus::kOk;
  if (auto learned = learning_.Add(setup_, noise, measurement, *out)) {
    TakeLearned(*learned);
  } else if (!frames_.empty()) {
    const bool is_longer = Extend(measurement, noise, out->used_tags);
    if (is_longer && (IsUseless() || Contradicts(noise))) {
      frames_.pop_back();  // it is not told
      End();
    } else if (!is_longer) {
      End();
    }
  }
  if (frames_.empty() && model_ && has_tags_state) {
    BeginFromTags(out->current, TagsOfState(measurement, *out), noise);
  }
  if (!frames_.empty() && !frames_.back().tags.empty()) last_tag_ns_ = frames_.back().t_ns;
  TakeInto(&out->current);
  if (!frames_.empty()) Open(out->current.t_ns, &out->current);
  AddTo(&out->lagged);
  if (static_cast<int>(frames_.size()) > setup_.options.window_frames) LetOldestLeave();
  DropOldSamples();
}

void WindowImu::AddTo(std::vector<FrameEstimate>* lagged) {
  for (FrameEstimate& frame : *lagged) TakeInto(&frame);
  if (lagged->empty()) return;
  while (!left_.empty() && left_.front().t_ns <= lagged->back().t_ns) left_.pop_front();
}

// The next frame with a state by tags begins a chain with what was learned, and the biases as they
// were at the newest frame that it was learned from.
void WindowImu::TakeLearned(const ImuSolution& solved) {
  End();
  model_ = solved.model;
  found_ = solved.found;
  in_body_ = InBody(learning_.samples(), model_->calibration);
  const int last = solved.solution.covariance.size() - 1;
  Block covariance = solved.solution.covariance.At(last, last);
  for (const Eigen::VectorXd& error : solved.shared_errors) {
    covariance += error.tail<kBlockSize>() * error.tail<kBlockSize>().transpose();
  }
  biases_ = solved.input.frames.back().acceleration;
  bias_covariance_.setZero();
  bias_covariance_.bottomRightCorner<6, 6>() = covariance.bottomRightCorner<6, 6>();
}

// A chain of a frame whose state and covariance have all that is known of it.
void WindowImu::Begin(const GraphFrame& frame, const Block& covariance, const NoiseModel& noise) {
  GraphInput input;
  input.frames = {frame};
  input.frames[0].tags.clear();
  input.frames[0].others.clear();
  input.prior =
      PriorOn(ToGraphState(frame.t_ns, frame.state, frame.acceleration, frame.motion), covariance);
  chain_ = QuadraticChain(BuildWholeGraph(setup_, WithImu(noise), input));
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
}

// The frame as the chain's next one; false where the IMU does not reach it.
bool WindowImu::Extend(const FrameMeasurements& measurement, const NoiseModel& noise,
                       const std::vector<int>& used) {
  const GraphFrame& before = frames_.back();
  const ImuBias bias = BiasOf(before.acceleration);
  const ImuNoise white = NoiseOf(options_, model_->scale);
  const auto motion =
      Preintegrate(in_body_, before.t_ns, measurement.t_ns, bias, white, kLongestImuStepS);
  if (!motion) return false;
  GraphFrame frame;
  frame.t_ns = measurement.t_ns;
  frame.state = CarryOn(before.state, *motion, model_->calibration.gravity_world_mps2);
  frame.acceleration = before.acceleration;
  if (const auto at = ImuAt(in_body_, frame.t_ns, kLongestImuStepS)) {
    frame.state.twist.omega_body = at->gyro_radps - bias.gyro_radps;
  }
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
  return true;
}

// The tags that the window took, and those that lie where they may be expected.
std::vector<TagDetection> WindowImu::TagsNear(const GraphFrame& frame, const Block& covariance,
                                              const std::vector<TagDetection>& tags,
                                              const std::vector<int>& used) const {
  constexpr double kNearPx = 5, kSigmas = 4;
  const double turn = std::sqrt(covariance.topLeftCorner<3, 3>().trace()),
               way = std::sqrt(covariance.block<3, 3>(3, 3).trace());
  std::vector<TagDetection> out;
  GraphFrame one = frame;
  for (const TagDetection& tag : tags) {
    const MountedCamera camera = setup_.CameraOf(tag.camera);
    const Pose cam_from_map = camera.CamFromMap(frame.state.world_from_body);
    const double depth_m = (cam_from_map * setup_.map.CornersInWorld(tag.id).front()).norm();
    const double near_px =
        kNearPx + kSigmas * camera.camera.fx * (turn + way / std::max(0.05, depth_m));
    one.tags = {tag};
    const std::vector<double> errors = ReprojectionErrors(setup_, one);
    const bool near =
        errors.size() == 4 && *std::max_element(errors.begin(), errors.end()) < near_px;
    if (near || IsAmong(tag.id, used)) out.push_back(tag);
  }
  return out;
}

// Of a state that says nothing any more.
bool WindowImu::IsUseless() const {
  constexpr double kMostM = 0.5, kMostRad = 0.3;
  const int newest = static_cast<int>(frames_.size()) - 1;
  const Block& p = covariance_.At(newest, newest);
  const double turn = p.topLeftCorner<3, 3>().trace(), way = p.block<3, 3>(3, 3).trace();
  return !(turn < kMostRad * kMostRad && way < kMostM * kMostM);
}

// Most of the newest frame's tags lie elsewhere, though they were solved with.
bool WindowImu::Contradicts(const NoiseModel& noise) const {
  const GraphFrame& newest = frames_.back();
  const auto agrees = [&](const TagDetection& tag) {
    return AgreesWith(setup_, noise, newest.state, tag);
  };
  const auto n = std::count_if(newest.tags.begin(), newest.tags.end(), agrees);
  return 2 * static_cast<size_t>(n) < newest.tags.size();
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
  chain_.MarginalizeFirst();
  frames_.erase(frames_.begin());
  BlockBandedMatrix rest(covariance_.size() - 1, covariance_.bandwidth());
  for (int k = 0; k < rest.size(); ++k) rest.At(k, k) = covariance_.At(k + 1, k + 1);
  covariance_ = std::move(rest);
}

// What is not known of gravity and of the clock, since the last frame with tags and altogether.
void WindowImu::Open(int64_t t_ns, FrameEstimate* frame) const {
  frame->covariance += OfClock(frame->state, found_->time_offset_sigma_s);
  const double gap_s = std::max(0.0, ToSeconds(t_ns - last_tag_ns_));
  const double accel = options_.gravity_mps2 * found_->gravity_sigma_rad;
  const double velocity = accel * gap_s, way = 0.5 * velocity * gap_s;
  for (int axis = 0; axis < 3; ++axis) {
    frame->covariance(3 + axis, 3 + axis) += way * way;
    frame->covariance(6 + axis, 6 + axis) += velocity * velocity;
    frame->covariance(3 + axis, 6 + axis) += way * velocity;
    frame->covariance(6 + axis, 3 + axis) += way * velocity;
  }
}

void WindowImu::TakeInto(FrameEstimate* frame) const {
  const auto take = [&](const BodyState& state, const StateCovariance& covariance, bool has_tags) {
    frame->state = state;
    frame->covariance = covariance;
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
  if (in_body_.empty()) return;
  const int64_t needed_ns = frames_.empty() ? in_body_.back().t_ns : frames_.front().t_ns;
  const int64_t keep_ns = needed_ns - 200'000'000;
  const auto old = std::find_if(in_body_.begin(), in_body_.end(),
                                [&](const ImuSample& sample) { return sample.t_ns >= keep_ns; });
  constexpr std::ptrdiff_t kWorthIt = 200;
  if (old - in_body_.begin() > kWorthIt) in_body_.erase(in_body_.begin(), old);
}

std::optional<StateAndCovariance> WindowImu::PredictAt(int64_t t_ns) const {
  if (frames_.empty()) return std::nullopt;
  const GraphFrame& last = frames_.back();
  const auto motion = Preintegrate(in_body_, last.t_ns, t_ns, BiasOf(last.acceleration),
                                   NoiseOf(options_, model_->scale), kLongestImuStepS);
  if (!motion) return std::nullopt;
  const int newest = static_cast<int>(frames_.size()) - 1;
  StateAndCovariance out{CarryOn(last.state, *motion, model_->calibration.gravity_world_mps2),
                         BodyCovariance(covariance_, newest)};
  // Of the pose: what the velocity carries on, and the IMU's own noise.
  StateCovariance onward = StateCovariance::Identity();
  onward.block<3, 3>(3, 6).diagonal().setConstant(motion->dt_s);
  out.covariance = (onward * out.covariance * onward.transpose()).eval();
  const Eigen::Matrix3d rotation = last.state.world_from_body.rotation().toRotationMatrix();
  out.covariance.block<3, 3>(0, 0) += motion->covariance.block<3, 3>(0, 0);
  out.covariance.block<3, 3>(3, 3) +=
      rotation * motion->covariance.block<3, 3>(6, 6) * rotation.transpose();
  out.covariance.block<3, 3>(6, 6) +=
      rotation * motion->covariance.block<3, 3>(3, 3) * rotation.transpose();
  return out;
}

std::optional<std::string> WindowImu::Warning() const {
  if (model_) return std::nullopt;
  return "the IMU is left out: " + learning_.refusal();
}

}  // namespace tagtwist::internal
