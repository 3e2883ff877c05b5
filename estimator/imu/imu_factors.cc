#include "estimator/imu/imu_factors.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "frontend/types/so3.h"
#include "residuals/imu_residual.h"

namespace tagtwist::internal {
namespace {

using SampleRange =
    std::pair<std::vector<ImuSample>::const_iterator, std::vector<ImuSample>::const_iterator>;

SampleRange Within(const std::vector<ImuSample>& samples, int64_t from_ns, int64_t to_ns) {
  const auto earlier = [](const ImuSample& sample, int64_t t_ns) { return sample.t_ns < t_ns; };
  const auto first = std::lower_bound(samples.begin(), samples.end(), from_ns, earlier);
  return {first, std::lower_bound(first, samples.end(), to_ns, earlier)};
}

// Mean square acceleration of the body over an interval [m^2/s^4].
double MeanSquareAcceleration(const SampleRange& samples, const GraphFrame& before,
                              const Eigen::Vector3d& gravity_world_mps2) {
  const ImuBias bias = BiasOf(before.acceleration);
  Eigen::Quaterniond world_from_body = before.state.world_from_body.rotation();
  double sum = 0;
  for (auto sample = samples.first; sample != samples.second; ++sample) {
    if (sample != samples.first) {
      const double step_s = ToSeconds(sample->t_ns - (sample - 1)->t_ns);
      world_from_body = world_from_body * ExpSo3(step_s * (sample->gyro_radps - bias.gyro_radps));
    }
    const Eigen::Vector3d force = sample->accel_mps2 - bias.accel_mps2;
    sum += (world_from_body * force + gravity_world_mps2).squaredNorm();
  }
  return sum / static_cast<double>(std::max<std::ptrdiff_t>(1, samples.second - samples.first));
}

// A line through the gyro's rates, over at least two samples.
struct LineThroughRates {
  double count = 0;
  double step_s = 0;            // from sample to sample
  double middle_s = 0;          // of their times, from the first
  double squares_s2 = 0;        // sum of those about the middle
  Eigen::Vector3d mean, slope;  // [rad/s], [rad/s^2]
  double about_line = 0;        // mean square of the rest, 3-D [rad^2/s^2]
};

LineThroughRates FitLine(const SampleRange& samples) {
  LineThroughRates out;
  const int64_t from_ns = samples.first->t_ns;
  out.count = static_cast<double>(samples.second - samples.first);
  out.step_s = ToSeconds((samples.second - 1)->t_ns - from_ns) / (out.count - 1);
  out.mean.setZero();
  out.slope.setZero();
  for (auto sample = samples.first; sample != samples.second; ++sample) {
    out.middle_s += ToSeconds(sample->t_ns - from_ns) / out.count;
    out.mean += sample->gyro_radps / out.count;
  }
  for (auto sample = samples.first; sample != samples.second; ++sample) {
    const double t_s = ToSeconds(sample->t_ns - from_ns) - out.middle_s;
    out.slope += t_s * sample->gyro_radps;
    out.squares_s2 += t_s * t_s;
  }
  out.slope /= out.squares_s2;
  for (auto sample = samples.first; sample != samples.second; ++sample) {
    const double t_s = ToSeconds(sample->t_ns - from_ns) - out.middle_s;
    out.about_line += (sample->gyro_radps - out.mean - t_s * out.slope).squaredNorm() /
                      std::max(1.0, out.count - 2);
  }
  return out;
}

// Densities of white noise on acceleration under which what was measured is nothing at all: so many
// times those that it makes likeliest. Of the rates by a line over three such intervals, for
// samples of a gyro are noisy, and what they scatter about it beyond that noise.
MotionScale MeasuredMotion(const std::vector<ImuSample>& samples, const GraphFrame& before,
                           const GraphFrame& frame, const ImuCalibration& calibration,
                           const ImuNoise& noise) {
  constexpr double kNoiseAndMore = 1.5;
  const int64_t dt_ns = frame.t_ns - before.t_ns;
  const double dt_s = ToSeconds(dt_ns);
  const double linear = MeanSquareAcceleration(Within(samples, before.t_ns, frame.t_ns), before,
                                               calibration.gravity_world_mps2);
  const SampleRange around = Within(samples, before.t_ns - dt_ns, frame.t_ns + dt_ns);
  double angular = noise.gyro * noise.gyro;
  if (around.second - around.first > 2) {
    const LineThroughRates line = FitLine(around);
    const double of_noise = kNoiseAndMore * 3 * noise.gyro * noise.gyro / line.step_s;
    angular +=
        line.slope.squaredNorm() * dt_s / 3 + std::max(0.0, line.about_line - of_noise) / dt_s;
  }
  return {kFreeMotion * (linear * dt_s / 3 + noise.accel * noise.accel), kFreeMotion * angular};
}

MotionScale Elsewhere(const MotionScale& scale, double dt_s) {
  const double share = std::clamp(dt_s / kElsewhereS, 0.01, 1.0);
  return {share * scale.linear, share * scale.angular};
}

Factor MotionOfImu(const Preintegration& motion, const ImuCalibration& calibration,
                   const ImuOptions& options) {
  Factor out;
  out.kind = FactorKind::kOther;
  out.blocks = {{BlockRef::Kind::kPose, -1},
                {BlockRef::Kind::kRates, -1},
                {BlockRef::Kind::kPose, 0},
                {BlockRef::Kind::kRates, 0}};
  const double root_s = std::sqrt(motion.dt_s);
  const auto cost = std::make_shared<ImuResidual>(
      motion, calibration.body_from_imu.translation(), calibration.gravity_world_mps2,
      root_s * options.gyroscope_random_walk, root_s * options.accelerometer_random_walk);
  out.own_log_det = cost->LogDetInformation();
  out.cost = cost;
  return out;
}

Factor WalkOfBiases(double dt_s, const ImuOptions& options) {
  Factor out;
  out.kind = FactorKind::kOther;
  out.blocks = {{BlockRef::Kind::kRates, -1}, {BlockRef::Kind::kRates, 0}};
  const double root_s = std::sqrt(dt_s);
  const auto cost = std::make_shared<BiasWalkResidual>(root_s * options.gyroscope_random_walk,
                                                       root_s * options.accelerometer_random_walk);
  out.own_log_det = cost->LogDetInformation();
  out.cost = cost;
  return out;
}

// The gyro at a frame, by a line through the samples around it: within half an interval between
// frames to either side, and at least the two next ones. What they scatter about the line beyond
// their noise may be a bend in it, and widens the sigma.
std::optional<Factor> RateOfGyro(const std::vector<ImuSample>& samples, int64_t t_ns,
                                 int64_t interval_ns, double density) {
  if (!Covers(samples, t_ns)) return std::nullopt;
  constexpr int64_t kWidestNs = 50'000'000;
  const int64_t reach_ns = std::min(kWidestNs, interval_ns / 2);
  SampleRange near = Within(samples, t_ns - reach_ns, t_ns + reach_ns + 1);
  const SampleRange next =
      Within(samples, t_ns, t_ns);  // empty, before the first that is not earlier
  if (near.first == near.second) near = next;
  if (near.first > samples.begin() && near.first >= next.first) --near.first;
  if (near.second < samples.end() && near.second <= next.first) ++near.second;
  if (near.second - near.first < 2) return std::nullopt;
  const LineThroughRates line = FitLine(near);
  const double white = density * density / line.step_s;
  const double from_middle_s = ToSeconds(t_ns - near.first->t_ns) - line.middle_s;
  const double bend = line.count > 2 ? std::max(0.0, line.about_line / 3 - 1.5 * white) : 0.0;
  const double sigma =
      std::sqrt(white * (1 / line.count + from_middle_s * from_middle_s / line.squares_s2) + bend);
  Factor out;
  out.kind = FactorKind::kOther;
  out.blocks = {{BlockRef::Kind::kRates, 0}};
  out.cost = std::make_shared<GyroRateResidual>(line.mean + from_middle_s * line.slope, sigma);
  out.own_log_det = -6 * std::log(sigma);
  return out;
}

// The axes about which it turns.
Eigen::Matrix<double, 3, 2> AcrossGravity(const ImuCalibration& calibration) {
  const Eigen::Vector3d down = calibration.gravity_world_mps2.normalized();
  Eigen::Matrix<double, 3, 2> out;
  out.col(0) = down.unitOrthogonal();
  out.col(1) = down.cross(out.col(0));
  return out;
}

}  // namespace

Eigen::Matrix<double, 3, 2> ByTurns(const ImuCalibration& calibration) {
  return -Hat(calibration.gravity_world_mps2) * AcrossGravity(calibration);
}

ImuCalibration Retract(const ImuCalibration& calibration, const ImuStep& step) {
  ImuCalibration out = calibration;
  out.gravity_world_mps2 =
      ExpSo3(AcrossGravity(calibration) * step.head<2>()) * calibration.gravity_world_mps2;
  out.time_offset_s += step(2);
  out.body_from_imu = Retract(calibration.body_from_imu, step.tail<6>());
  return out;
}

ImuCalibration CalibrationAsTold(const ImuOptions& options) {
  return {{0, 0, -options.gravity_mps2}, options.time_offset_s, options.body_from_imu};
}

ImuSample InBody(const ImuSample& sample, const ImuCalibration& calibration) {
  return {sample.t_ns - std::llround(1e9 * calibration.time_offset_s),
          calibration.body_from_imu.rotation() * sample.accel_mps2,
          calibration.body_from_imu.rotation() * sample.gyro_radps};
}

std::vector<ImuSample> InBody(const std::vector<ImuSample>& samples,
                              const ImuCalibration& calibration) {
  std::vector<ImuSample> out;
  out.reserve(samples.size());
  for (const ImuSample& sample : samples) out.push_back(InBody(sample, calibration));
  return out;
}

bool Covers(const std::vector<ImuSample>& samples, int64_t t_ns) {
  return ImuAt(samples, t_ns, kLongestImuStepS).has_value();
}

std::optional<Eigen::Vector3d> RateAt(const std::vector<ImuSample>& samples, int64_t t_ns,
                                      const ImuBias& bias) {
  const auto at = ImuAt(samples, t_ns, kLongestImuStepS);
  if (!at) return std::nullopt;
  return at->gyro_radps - bias.gyro_radps;
}

bool SetImuFactors(const std::vector<ImuSample>& samples, const ImuOptions& options,
                   const ImuModel& model, const GraphFrame* before, GraphFrame* frame) {
  const ImuNoise noise = NoiseOf(options, model.scale);
  frame->others.clear();
  const int64_t interval_ns = before == nullptr ? 0 : frame->t_ns - before->t_ns;
  frame->motion = Elsewhere(model.elsewhere, ToSeconds(interval_ns));
  if (auto rate = RateOfGyro(samples, frame->t_ns, interval_ns, noise.gyro)) {
    frame->others.push_back(std::move(*rate));
  }
  if (before == nullptr) return false;
  const auto motion = Preintegrate(samples, before->t_ns, frame->t_ns, BiasOf(before->acceleration),
                                   noise, kLongestImuStepS);
  if (!motion) {
    frame->others.push_back(WalkOfBiases(ToSeconds(interval_ns), options));
    return false;
  }
  frame->others.push_back(MotionOfImu(*motion, model.calibration, options));
  frame->motion = MeasuredMotion(samples, *before, *frame, model.calibration,
                                 NoiseOf(options, model.of_motion));
  return true;
}

int SetImuFactors(const ImuRecord& imu, const ImuModel& model, std::vector<GraphFrame>* frames) {
  const std::vector<ImuSample> samples = InBody(imu.samples, model.calibration);
  int covered = 0;
  for (size_t k = 0; k < frames->size(); ++k) {
    const GraphFrame* before = k == 0 ? nullptr : &(*frames)[k - 1];
    covered += SetImuFactors(samples, imu.options, model, before, &(*frames)[k]) ? 1 : 0;
  }
  return covered;
}

Eigen::Vector3d VelocityOfImu(const BodyState& state, const ImuCalibration& calibration) {
  return state.twist.v_world +
         state.world_from_body.rotation() *
             state.twist.omega_body.cross(calibration.body_from_imu.translation());
}

BodyState CarryOn(const BodyState& state, const Preintegration& motion,
                  const ImuCalibration& calibration, const Eigen::Vector3d& omega_body_radps) {
  const Eigen::Quaterniond before = state.world_from_body.rotation(),
                           after = (before * motion.rotation).normalized();
  const Eigen::Vector3d place = calibration.body_from_imu.translation();
  const Eigen::Vector3d gained = motion.dt_s * calibration.gravity_world_mps2;
  const Eigen::Vector3d velocity = VelocityOfImu(state, calibration);
  const Eigen::Vector3d position = state.world_from_body * place +
                                   motion.dt_s * (velocity + 0.5 * gained) +
                                   before * motion.position_m;
  BodyState out{MakePose(after, position - after * place), {velocity, omega_body_radps}};
  out.twist.v_world +=
      gained + before * motion.velocity_mps - after * omega_body_radps.cross(place);
  return out;
}

ImuNoise NoiseOf(const ImuOptions& options, const ImuNoiseScale& scale) {
  return {scale.gyro * options.gyroscope_noise_density,
          scale.accel * options.accelerometer_noise_density};
}

ImuBias BiasOf(const Acceleration& acceleration) {
  return {acceleration.alpha_body, acceleration.a_world};
}

}  // namespace tagtwist::internal
