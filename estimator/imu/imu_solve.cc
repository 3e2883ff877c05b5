#include "estimator/imu/imu_solve.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/imu/imu_border.h"
#include "estimator/imu/imu_start.h"
#include "frontend/base/format_text.h"
#include "frontend/types/so3.h"
#include "residuals/imu_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kStateSize = BlockBandedMatrix::kSize;

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
    if (is_covered) motion = {kUsual * motion.linear, kUsual * motion.angular};
  }
}

class ImuSolver {
 public:
  ImuSolver(const EstimatorSetup& setup, const NoiseModel& noise, const ImuRecord& imu,
            std::vector<GraphFrame> frames)
      : setup_(setup), noise_(WithImu(noise)), imu_(imu) {
    model_.elsewhere = MotionWithoutImu(frames);
    input_.frames = std::move(frames);
  }

  Status Start(const ImuModel* known) {
    std::vector<GraphFrame> seen;
    for (const GraphFrame& frame : input_.frames) {
      if (!frame.tags.empty()) seen.push_back(frame);
    }
    const auto start = StartImu(imu_, seen);
    if (!start) return start.error();
    model_.calibration = reference_ = start->calibration;
    model_.scale = scatter_ = start->scale;
    PutStart(imu_, *start, &input_.frames);
    if (known != nullptr) {
      model_.calibration = known->calibration;
      model_.scale = known->scale;
    }
    return Ok();
  }

  // States and calibration under the noise as it is.
  Status Solve(int most_rounds) {
    model_.of_motion = model_.scale;
    for (int round = 0; round < most_rounds; ++round) {
      if (const Status solved = SolveStates(); !solved) return solved;
      border_ = MakeBorder(imu_.options, model_, reference_, solution_.graph);
      if (!border_) return Error{"the IMU's calibration is tied by nothing"};
      model_.calibration = Retract(model_.calibration, border_->step);
      if (border_->StepInSigmas() < 0.1) break;
    }
    return SolveStates();
  }

  // Each density by the likelihood, in ever finer steps.
  Status LearnNoise(const std::vector<double>& factors) {
    double here = LogEvidence();
    for (const double factor : factors) {
      for (double ImuNoiseScale::*part : {&ImuNoiseScale::gyro, &ImuNoiseScale::accel}) {
        if (const Status climbed = Climb(part, factor, &here); !climbed) return climbed;
      }
    }
    return SolveStates();
  }

  ImuSolution Finish() && {
    ImuSolution out;
    out.found = Found();
    if (border_) out.calibration_covariance = border_->covariance;
    if (border_) out.shared_errors = std::move(border_->shared_errors);
    out.noise = noise_;
    out.model = model_;
    out.solution = std::move(solution_);
    LetInterpolate(input_.frames, &out.solution.graph.states);
    out.input = std::move(input_);
    return out;
  }

 private:
  // One density by steps of a factor either way while the likelihood grows.
  Status Climb(double ImuNoiseScale::*part, double factor, double* here) {
    constexpr int kMostSteps = 8;
    for (const double step : {factor, 1 / factor}) {
      for (int i = 0; i < kMostSteps; ++i) {
        const double before = model_.scale.*part;
        model_.scale.*part *= step;
        if (const Status solved = SolveStates(); !solved) return solved;
        if (!(LogEvidence() > *here)) {
          model_.scale.*part = before;
          if (i == 0) break;  // the other way
          return Ok();
        }
        *here = LogEvidence();
      }
    }
    return Ok();
  }

  // Of the noise as it is: the likelihood, and that it is about what the samples scatter by, hardly
  // less. Where tags say little the likelihood takes the biases' wander for it, and comes out at a
  // fifth of it: velocities were three sigma off.
  double LogEvidence() const {
    constexpr double kBelow = 0.35, kAbove = 1;
    const auto squared = [](double ratio) {
      return std::pow(std::log(ratio) / (ratio < 1 ? kBelow : kAbove), 2);
    };
    return solution_.log_likelihood - 0.5 * (squared(model_.scale.gyro / scatter_.gyro) +
                                             squared(model_.scale.accel / scatter_.accel));
  }

  Status SolveStates() {
    intervals_ = SetImuFactors(imu_, model_, &input_.frames);
    auto solved = SolveAndInvert(setup_, noise_, input_, {setup_.options.max_iterations});
    if (!solved) return solved.error();
    solution_ = std::move(*solved);
    TakeStates(solution_.graph, &input_.frames);
    return Ok();
  }

  ImuResult Found() const {
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

  const EstimatorSetup& setup_;
  NoiseModel noise_;
  const ImuRecord& imu_;
  GraphInput input_;
  ImuModel model_;
  ImuCalibration reference_;
  ImuNoiseScale scatter_;
  Solution solution_;
  int intervals_ = 0;
  std::optional<ImuBorder> border_;
};

}  // namespace

Result<ImuSolution> SolveWithImu(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const ImuRecord& imu, std::vector<GraphFrame> frames,
                                 const ImuModel* known, bool by_likelihood) {
  constexpr int kFirstRounds = 5, kLastRounds = 3;
  ImuSolver solver(setup, noise, imu, std::move(frames));
  if (const Status started = solver.Start(known); !started) return started.error();
  if (const Status solved = solver.Solve(kFirstRounds); !solved) return solved.error();
  std::vector<std::vector<double>> rounds = {{2.0, 1.41, 1.19}, {1.41, 1.19}};
  if (known != nullptr) rounds.erase(rounds.begin());
  if (!imu.options.learn_noise || !by_likelihood) rounds.clear();
  for (const std::vector<double>& factors : rounds) {
    if (const Status learned = solver.LearnNoise(factors); !learned) return learned.error();
    if (const Status solved = solver.Solve(kLastRounds); !solved) return solved.error();
  }
  return std::move(solver).Finish();
}

void Widen(double common_rotation_sigma_rad, ImuResult* found) {
  found->gravity_sigma_rad = std::hypot(found->gravity_sigma_rad, common_rotation_sigma_rad);
  for (double& sigma : found->mount_sigma_rad) {
    sigma = std::hypot(sigma, common_rotation_sigma_rad);
  }
}

NoiseModel WithImu(const NoiseModel& noise) {
  NoiseModel out = noise;
  out.linear = out.angular = {WhiteNoiseOn::kAcceleration, 1.0, /*leaves_third_free=*/true};
  return out;
}

void AddSharedErrors(const std::vector<Eigen::VectorXd>& errors, Trajectory* trajectory,
                     std::vector<StateCovariance>* covariances) {
  for (const Eigen::VectorXd& error : errors) {
    for (size_t k = 0; k < trajectory->states.size(); ++k) {
      const auto at = error.segment<kStateSize>(static_cast<Eigen::Index>(k) * kStateSize);
      trajectory->covariances[k] += at * at.transpose();
      (*covariances)[k] += at.head<12>() * at.head<12>().transpose();
      if (k == 0) continue;
      const auto before = error.segment<kStateSize>(static_cast<Eigen::Index>(k - 1) * kStateSize);
      trajectory->cross_covariances[k - 1] += at * before.transpose();
    }
  }
}

std::string TextOf(const ImuResult& found) {
  const auto& g = found.gravity_world_mps2;
  const Eigen::Vector3d place_mm = 1e3 * found.imu_in_body_m;
  constexpr double kDegPerRad = 57.29577951308232;
  return Format(
      "IMU: in the estimate over %d intervals; gravity (%.3f, %.3f, %.3f) m/s^2, its clock %+.2f "
      "+- %.2f ms, its axes %.2f +- %.2f deg from the set-up's, at (%.1f, %.1f, %.1f) +- %.1f mm "
      "in the body, noise %.2g rad/s and %.2g m/s^2 per root Hz",
      found.intervals, g.x(), g.y(), g.z(), 1e3 * found.time_offset_s,
      1e3 * found.time_offset_sigma_s, kDegPerRad * found.mount_rad.norm(),
      kDegPerRad * found.mount_sigma_rad.maxCoeff(), place_mm.x(), place_mm.y(), place_mm.z(),
      1e3 * found.imu_in_body_sigma_m.maxCoeff(), found.gyro_noise, found.accel_noise);
}

}  // namespace tagtwist::internal
