#include "estimator/imu/imu_start.h"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

constexpr double kDegPerRad = 57.29577951308232;

// A turn between two frames as tags and as the gyro say it [rad].
struct TurnPair {
  double dt_s;
  Eigen::Vector3d of_tags, of_gyro;
};

// The gyro's rates integrated from the first sample on, axis by axis: over a frame's interval the
// turn, but for what turns do to one another.
class GyroIntegral {
 public:
  explicit GyroIntegral(const std::vector<ImuSample>& samples) : samples_(samples) {
    sums_.reserve(samples.size());
    for (size_t i = 0; i < samples.size(); ++i) {
      sums_.push_back(i == 0 ? Eigen::Vector3d::Zero() : Onward(i, samples[i].t_ns));
    }
  }

  /// From `from_ns` to `to_ns`; nullopt where the samples do not cover it.
  std::optional<Eigen::Vector3d> Over(int64_t from_ns, int64_t to_ns) const {
    const auto from = At(from_ns), to = At(to_ns);
    if (!from || !to) return std::nullopt;
    return *to - *from;
  }

 private:
  Eigen::Vector3d Onward(size_t next, int64_t t_ns) const {
    const ImuSample &a = samples_[next - 1], &b = samples_[next];
    const double dt_s = ToSeconds(t_ns - a.t_ns), share = dt_s / ToSeconds(b.t_ns - a.t_ns);
    return sums_[next - 1] + dt_s * ((1 - 0.5 * share) * a.gyro_radps + 0.5 * share * b.gyro_radps);
  }

  std::optional<Eigen::Vector3d> At(int64_t t_ns) const {
    const auto after =
        std::upper_bound(samples_.begin(), samples_.end(), t_ns,
                         [](int64_t t, const ImuSample& sample) { return t < sample.t_ns; });
    if (after == samples_.begin() || after == samples_.end()) return std::nullopt;
    if (ToSeconds(after->t_ns - (after - 1)->t_ns) > kLongestImuStepS) return std::nullopt;
    return Onward(static_cast<size_t>(after - samples_.begin()), t_ns);
  }

  const std::vector<ImuSample>& samples_;
  std::vector<Eigen::Vector3d> sums_;
};

// By a clock that is so much ahead of the frames'.
std::vector<TurnPair> Turns(const GyroIntegral& gyro, double offset_s,
                            const std::vector<GraphFrame>& frames) {
  constexpr double kLongestS = 0.5;
  const int64_t offset_ns = std::llround(1e9 * offset_s);
  std::vector<TurnPair> out;
  for (size_t k = 1; k < frames.size(); ++k) {
    const GraphFrame &a = frames[k - 1], &b = frames[k];
    const double dt_s = ToSeconds(b.t_ns - a.t_ns);
    if (dt_s > kLongestS) continue;
    const auto turn = gyro.Over(a.t_ns + offset_ns, b.t_ns + offset_ns);
    if (!turn) continue;
    out.push_back({dt_s,
                   LogSo3(a.state.world_from_body.rotation().conjugate() *
                          b.state.world_from_body.rotation()),
                   *turn});
  }
  return out;
}

// The gyro's mean error, of rates.
Eigen::Vector3d MeanError(const std::vector<TurnPair>& turns,
                          const Eigen::Matrix3d& body_from_imu) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double time_s = 0;
  for (const TurnPair& turn : turns) {
    sum += body_from_imu * turn.of_gyro - turn.of_tags;
    time_s += turn.dt_s;
  }
  return sum / time_s;
}

// Mean square of the rates' differences [rad^2/s^2].
double Misfit(const std::vector<TurnPair>& turns, const Eigen::Matrix3d& body_from_imu) {
  const Eigen::Vector3d error = MeanError(turns, body_from_imu);
  double sum = 0, time_s = 0;
  for (const TurnPair& turn : turns) {
    sum +=
        (body_from_imu * turn.of_gyro - turn.of_tags - turn.dt_s * error).squaredNorm() / turn.dt_s;
    time_s += turn.dt_s;
  }
  return sum / time_s;
}

// The rotation that lays the gyro's turns on those of the tags (Wahba's problem, Markley 1988).
Eigen::Matrix3d BestRotation(const std::vector<TurnPair>& turns) {
  Eigen::Vector3d mean_tags = Eigen::Vector3d::Zero(), mean_gyro = Eigen::Vector3d::Zero();
  for (const TurnPair& turn : turns) {
    mean_tags += turn.of_tags / static_cast<double>(turns.size());
    mean_gyro += turn.of_gyro / static_cast<double>(turns.size());
  }
  Eigen::Matrix3d b = Eigen::Matrix3d::Zero();
  for (const TurnPair& turn : turns) {
    b += (turn.of_tags - mean_tags) * (turn.of_gyro - mean_gyro).transpose();
  }
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(b, Eigen::ComputeFullU | Eigen::ComputeFullV);
  const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant();
  return svd.matrixU() * Eigen::Vector3d(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
}

// The clock by which the turns fit best, where that is told from the options'.
double StartOffset(const GyroIntegral& gyro, const ImuRecord& imu,
                   const std::vector<GraphFrame>& frames) {
  constexpr double kWithinS = 0.2, kStepS = 0.005, kBetter = 0.7, kLogsOfChance = 20;
  const double given_s = imu.options.time_offset_s;
  if (imu.options.time_offset_sigma_s == 0) return given_s;
  const auto misfit = [&](double offset_s) {
    const auto turns = Turns(gyro, offset_s, frames);
    return turns.size() < 10 ? std::numeric_limits<double>::infinity()
                             : Misfit(turns, BestRotation(turns));
  };
  // Of some noisy turns a few always fit better by chance.
  const auto n = static_cast<double>(std::max<size_t>(1, Turns(gyro, given_s, frames).size()));
  const double better = std::min(kBetter, std::exp(-kLogsOfChance / n));
  double best_s = given_s, least = better * misfit(given_s);
  for (double shift_s = kStepS; shift_s <= kWithinS; shift_s += kStepS) {
    for (const double offset_s : {given_s + shift_s, given_s - shift_s}) {
      const double there = misfit(offset_s);
      if (there < least) {
        least = there;
        best_s = offset_s;
      }
    }
  }
  return best_s;
}

Status CheckAxes(const std::vector<TurnPair>& turns, const Pose& as_told) {
  constexpr double kFarRad = 0.26, kMuchBetter = 0.25;
  const Eigen::Matrix3d told = as_told.rotation().toRotationMatrix(), fits = BestRotation(turns);
  const Eigen::Vector3d turn = LogSo3(Eigen::Quaterniond(fits * told.transpose()));
  if (turn.norm() < kFarRad || !(Misfit(turns, fits) < kMuchBetter * Misfit(turns, told))) {
    return Ok();
  }
  const Eigen::Vector3d axis = turn.normalized();
  const Eigen::Quaterniond q(fits);
  return Error{Format(
      "the IMU's axes are not the body's: its gyro fits what the tags say when turned by %.0f deg "
      "about (%.2f, %.2f, %.2f) of the body: imu.body_from_imu would have quaternion_xyzw [%.3f, "
      "%.3f, %.3f, %.3f]",
      kDegPerRad * turn.norm(), axis.x(), axis.y(), axis.z(), q.x(), q.y(), q.z(), q.w())};
}

// Mean over the frames of what the body's acceleration has beyond the force on it.
std::optional<Eigen::Vector3d> MeanGravity(const std::vector<ImuSample>& samples,
                                           const std::vector<GraphFrame>& frames,
                                           const ImuCalibration& calibration, const ImuBias& bias) {
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  double time_s = 0;
  for (size_t k = 1; k < frames.size(); ++k) {
    const GraphFrame &a = frames[k - 1], &b = frames[k];
    const auto motion = Preintegrate(samples, a.t_ns, b.t_ns, bias, {}, kLongestImuStepS);
    if (!motion) continue;
    sum += VelocityOfImu(b.state, calibration) - VelocityOfImu(a.state, calibration) -
           a.state.world_from_body.rotation() * motion->velocity_mps;
    time_s += motion->dt_s;
  }
  if (!(time_s > 0)) return std::nullopt;
  return sum / time_s;
}

}  // namespace

ImuNoiseScale ScaleOfScatter(const ImuRecord& imu) {
  constexpr size_t kFewest = 50;
  constexpr double kLeast = 0.05, kMost = 20;
  // Of a normal variable: its median distance from zero, and the root of 1 + 4 + 1.
  constexpr double kMedian = 0.6745, kOfDifference = 2.449;
  std::vector<double> gyro, accel, steps_s;
  const auto& samples = imu.samples;
  for (size_t i = 2; i < samples.size(); ++i) {
    const ImuSample &a = samples[i - 2], &b = samples[i - 1], &c = samples[i];
    const double before_s = ToSeconds(b.t_ns - a.t_ns), after_s = ToSeconds(c.t_ns - b.t_ns);
    if (std::max(before_s, after_s) > 1.5 * std::min(before_s, after_s)) continue;
    steps_s.push_back(after_s);
    const Eigen::Vector3d of_gyro = a.gyro_radps - 2 * b.gyro_radps + c.gyro_radps,
                          of_accel = a.accel_mps2 - 2 * b.accel_mps2 + c.accel_mps2;
    for (int axis = 0; axis < 3; ++axis) {
      gyro.push_back(std::abs(of_gyro(axis)));
      accel.push_back(std::abs(of_accel(axis)));
    }
  }
  if (steps_s.size() < kFewest) return {};
  const double root_s = std::sqrt(Quantile(steps_s, 0.5)) / (kMedian * kOfDifference);
  const ImuOptions& o = imu.options;
  return {std::clamp(root_s * Quantile(gyro, 0.5) / o.gyroscope_noise_density, kLeast, kMost),
          std::clamp(root_s * Quantile(accel, 0.5) / o.accelerometer_noise_density, kLeast, kMost)};
}

Result<ImuStart> StartImu(const ImuRecord& imu, const std::vector<GraphFrame>& frames) {
  ImuStart out;
  if (imu.options.learn_noise) out.scale = ScaleOfScatter(imu);
  out.calibration = CalibrationAsTold(imu.options);
  const GyroIntegral gyro(imu.samples);
  out.calibration.time_offset_s = StartOffset(gyro, imu, frames);
  const std::vector<ImuSample> samples = InBody(imu.samples, out.calibration);
  const std::vector<TurnPair> turns = Turns(gyro, out.calibration.time_offset_s, frames);
  if (turns.size() < 10) {
    return Error{
        Format("the IMU covers %zu of the intervals between frames with tags, at least 10 "
               "are needed",
               turns.size())};
  }
  const Pose& as_told = out.calibration.body_from_imu;
  if (const Status axes = CheckAxes(turns, as_told); !axes) return axes.error();
  out.gyro_bias_radps = MeanError(turns, as_told.rotation().toRotationMatrix());
  const auto gravity =
      MeanGravity(samples, frames, out.calibration, {out.gyro_bias_radps, Eigen::Vector3d::Zero()});
  constexpr double kNearG = 0.2;
  const double usual = imu.options.gravity_mps2;
  if (!gravity || std::abs(gravity->norm() - usual) > kNearG * usual) {
    return Error{Format(
        "what the accelerometer says beyond the body's motion is %.2f m/s^2, and gravity %.2f: its "
        "units, its axes or the map's size are not what the set-up says",
        gravity ? gravity->norm() : 0.0, usual)};
  }
  out.calibration.gravity_world_mps2 = usual * gravity->normalized();
  return out;
}

}  // namespace tagtwist::internal
