#include "estimator/imu/imu_solver.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "estimator/imu/imu_start.h"
#include "residuals/imu_residual.h"

namespace tagtwist::internal {
namespace {

// What the tags alone said of the motion, as densities on acceleration: for where there is no IMU.
MotionScale MotionWithoutImu(const std::vector<GraphFrame>& frames) {
  constexpr double kLeast = 1e-6;
  double linear = 0, angular = 0;
  int n = 0;
  size_t later = 0;
  for (const GraphFrame& frame : frames) {
    while (later < frames.size() && ToSeconds(frames[later].t_ns - frame.t_ns) < kElsewhereS)
      ++later;
    if (later == frames.size()) break;
    const double three_s = 3 * ToSeconds(frames[later].t_ns - frame.t_ns);
    const Twist &a = frame.state.twist, &b = frames[later].state.twist;
    linear += (b.v_world - a.v_world).squaredNorm() / three_s;
    angular += (b.omega_body - a.omega_body).squaredNorm() / three_s;
    ++n;
  }
  if (n == 0) return {};
  return {std::max(kLeast, linear / n), std::max(kLeast, angular / n)};
}

// Biases into all frames; those without tags to where the IMU carries the ones before them.
void PutStart(const ImuRecord& imu, const ImuStart& start, std::vector<GraphFrame>* frames) {
  const std::vector<ImuSample> samples = InBody(imu.samples, start.calibration);
  const ImuBias bias{start.gyro_bias_radps, Eigen::Vector3d::Zero()};
  for (size_t k = 0; k < frames->size(); ++k) {
    GraphFrame& frame = (*frames)[k];
    frame.acceleration = {bias.accel_mps2, bias.gyro_radps};
    const auto at = ImuAt(samples, frame.t_ns, kLongestImuStepS);
    if (at) frame.state.twist.omega_body = at->gyro_radps - bias.gyro_radps;
    if (k == 0 || !frame.tags.empty()) continue;
    const GraphFrame& before = (*frames)[k - 1];
    const auto motion = Preintegrate(samples, before.t_ns, frame.t_ns, bias, {}, kLongestImuStepS);
    if (!motion) continue;
    frame.state = CarryOn(before.state, *motion, start.calibration, frame.state.twist.omega_body);
  }
}

// By which the time between two frames is interpolated where the IMU covers it: what was measured
// is nothing unusual.
void LetInterpolate(const std::vector<GraphFrame>& frames, std::vector<GraphState>* states) {
  constexpr double kUsual = 4 / kFreeMotion;
  for (size_t k = 0; k < frames.size(); ++k) {
    const std::vector<Factor>& others = frames[k].others;
    const bool is_covered = std::any_of(others.begin(), others.end(), [](const Factor& factor) {
      return dynamic_cast<const ImuResidual*>(factor.cost.get()) != nullptr;
    });
    MotionScale& motion = (*states)[k].motion;
    if (is_covered) motion = {kUsual * motion.linear, kUsual * motion.angular, motion.breaks};
  }
}

}  // namespace

ImuSolver::ImuSolver(const EstimatorSetup& setup, const NoiseModel& noise, const ImuRecord& imu,
                     std::vector<GraphFrame> frames, const std::optional<ImuModel>& known,
                     bool by_likelihood)
    : setup_(setup), noise_(WithImu(noise)), imu_(imu), known_(known) {
  constexpr int kFirstRounds = 5, kLastRounds = 3;
  model_.elsewhere = MotionWithoutImu(frames);
  input_.frames = std::move(frames);
  std::vector<std::vector<double>> finer = {{2.0, 1.41, 1.19}, {1.41, 1.19}};
  if (known_) finer.erase(finer.begin());
  if (!imu_.options.learn_noise || !by_likelihood) finer.clear();
  tasks_.push_back({kFirstRounds});
  for (const std::vector<double>& factors : finer) {
    for (const double factor : factors) {
      tasks_.push_back({0, &ImuNoiseScale::gyro, factor});
      tasks_.push_back({0, &ImuNoiseScale::accel, factor});
    }
    tasks_.push_back({});
    tasks_.push_back({kLastRounds});
  }
}

Status ImuSolver::Start() {
  std::vector<GraphFrame> seen;
  for (const GraphFrame& frame : input_.frames) {
    if (!frame.tags.empty()) seen.push_back(frame);
  }
  const auto start = StartImu(imu_, seen);
  if (!start) return start.error();
  model_.calibration = reference_ = start->calibration;
  model_.scale = scatter_ = start->scale;
  PutStart(imu_, *start, &input_.frames);
  if (known_) {
    model_.calibration = known_->calibration;
    model_.scale = known_->scale;
  }
  has_started_ = true;
  return Ok();
}

Result<bool> ImuSolver::Advance() {
  if (!has_started_) {
    if (const Status started = Start(); !started) return started.error();
    Begin();
    return false;
  }
  const auto done = tasks_[task_].part != nullptr ? AdvanceClimb() : AdvanceRounds();
  if (!done) return done;
  if (*done && ++task_ < tasks_.size()) Begin();
  return task_ == tasks_.size();
}

// The task.
void ImuSolver::Begin() {
  round_ = 0;
  is_border_next_ = is_settled_ = goes_down_ = false;
  const bool is_first_climb = task_ > 0 && tasks_[task_ - 1].part == nullptr;
  if (tasks_[task_].part != nullptr && is_first_climb) evidence_ = LogEvidence();
  if (tasks_[task_].most_rounds > 0) model_.of_motion = model_.scale;
}

Result<bool> ImuSolver::AdvanceRounds() {
  if (!is_border_next_) {
    if (const Status solved = SolveStates(); !solved) return solved.error();
    is_border_next_ = round_ < tasks_[task_].most_rounds && !is_settled_;
    return !is_border_next_;
  }
  is_border_next_ = false;
  border_ = MakeBorder(imu_.options, model_, reference_, solution_.graph);
  if (!border_) return Error{"the IMU's calibration is tied by nothing"};
  model_.calibration = Retract(model_.calibration, border_->step);
  is_settled_ = border_->StepInSigmas() < 0.1;
  ++round_;
  return false;
}

Result<bool> ImuSolver::AdvanceClimb() {
  constexpr int kMostSteps = 8;
  const Task& task = tasks_[task_];
  double& density = model_.scale.*task.part;
  const double before = density;
  density *= goes_down_ ? 1 / task.factor : task.factor;
  if (const Status solved = SolveStates(); !solved) return solved.error();
  if (LogEvidence() > evidence_) {
    evidence_ = LogEvidence();
    if (++round_ < kMostSteps) return false;
  } else {
    density = before;
    if (round_ > 0) return true;
  }
  round_ = 0;
  return std::exchange(goes_down_, true);  // the other way, once
}

ImuSolution ImuSolver::Finish() && {
  ImuSolution out;
  out.found = Found();
  if (border_) out.calibration_covariance = border_->covariance;
  if (border_) out.shared_errors = std::move(border_->shared_errors);
  LetInterpolate(input_.frames, &solution_.graph.states);
  out.input = std::move(input_);
  out.noise = noise_;
  out.model = model_;
  out.solution = std::move(solution_);
  return out;
}

// Of the noise as it is: the likelihood, and that it is about what the samples scatter by, hardly
// less. Where tags say little the likelihood takes the biases' wander for it, and comes out at a
// fifth of it: velocities were three sigma off.
double ImuSolver::LogEvidence() const {
  constexpr double kBelow = 0.35, kAbove = 1;
  const auto squared = [](double ratio) {
    return std::pow(std::log(ratio) / (ratio < 1 ? kBelow : kAbove), 2);
  };
  return solution_.log_likelihood - 0.5 * (squared(model_.scale.gyro / scatter_.gyro) +
                                           squared(model_.scale.accel / scatter_.accel));
}

Status ImuSolver::SolveStates() {
  intervals_ = SetImuFactors(imu_, model_, &input_.frames);
  auto solved = SolveAndInvert(setup_, noise_, input_, {setup_.options.max_iterations});
  if (!solved) return solved.error();
  solution_ = std::move(*solved);
  TakeStates(solution_.graph, &input_.frames);
  return Ok();
}

ImuResult ImuSolver::Found() const {
  ImuResult out;
  out.gravity_world_mps2 = model_.calibration.gravity_world_mps2;
  out.time_offset_s = model_.calibration.time_offset_s;
  const Pose& found = model_.calibration.body_from_imu;
  out.mount_rad = Difference(found, imu_.options.body_from_imu).head<3>();
  out.imu_in_body_m = found.translation();
  if (border_) {
    const ImuStep sigmas = border_->covariance.diagonal().cwiseMax(0).cwiseSqrt();
    out.gravity_sigma_rad = sigmas.head<2>().maxCoeff();
    out.time_offset_sigma_s = sigmas(2);
    out.mount_sigma_rad = sigmas.segment<3>(3);
    out.imu_in_body_sigma_m = sigmas.tail<3>();
  }
  const size_t middle = input_.frames.size() / 2;
  const auto k = static_cast<int>(middle);
  const ImuBias bias = BiasOf(input_.frames[middle].acceleration);
  const auto variances = solution_.covariance.At(k, k).diagonal();
  out.gyro_bias_radps = bias.gyro_radps;
  out.accel_bias_mps2 = bias.accel_mps2;
  out.accel_bias_sigma_mps2 = variances.segment<3>(12).cwiseSqrt();
  out.gyro_bias_sigma_radps = variances.segment<3>(15).cwiseSqrt();
  out.gyro_noise = model_.scale.gyro * imu_.options.gyroscope_noise_density;
  out.accel_noise = model_.scale.accel * imu_.options.accelerometer_noise_density;
  out.intervals = intervals_;
  return out;
}

}  // namespace tagtwist::internal
