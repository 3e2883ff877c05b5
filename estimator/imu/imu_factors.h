#pragma once
#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/imu/imu_options.h"
#include "residuals/preintegration.h"

namespace tagtwist::internal {

/// How an IMU stands against the body, the frames' stamps and the world. Error state, 9 entries:
/// turn of gravity about two axes across it [rad], time offset [s], step of body_from_imu (pose.h).
struct ImuCalibration {
  Eigen::Vector3d gravity_world_mps2{0, 0, -9.81};
  double time_offset_s = 0;  // the IMU's clock less that of the frames' stamps
  Pose body_from_imu;
};
constexpr int kImuEntries = 9;
using ImuStep = Eigen::Matrix<double, kImuEntries, 1>;
using ImuStepCovariance = Eigen::Matrix<double, kImuEntries, kImuEntries>;
ImuCalibration Retract(const ImuCalibration& calibration, const ImuStep& step);
/// Derivative of gravity in W by the first two entries of a step.
Eigen::Matrix<double, 3, 2> ByTurns(const ImuCalibration& calibration);

/// What white noise is: the options' densities times what was learned.
struct ImuNoiseScale {
  double gyro = 1, accel = 1;
};

/// How its samples are read, and the motion's density where it covers no interval.
struct ImuModel {
  ImuCalibration calibration;
  ImuNoiseScale scale;
  ImuNoiseScale of_motion;  // that the motion's densities are told from: not moved while the other
                            // is learned, for these would follow it
  MotionScale elsewhere;    // over kElsewhereS; over less, accelerations last, and it is less
};
inline constexpr double kElsewhereS = 0.25;

/// As the options have it; gravity along -z of W.
ImuCalibration CalibrationAsTold(const ImuOptions& options);

/// A sample with the body's axes, by the clock of the frames; still of where the IMU is.
ImuSample InBody(const ImuSample& sample, const ImuCalibration& calibration);
std::vector<ImuSample> InBody(const std::vector<ImuSample>& samples,
                              const ImuCalibration& calibration);

/// Neighbouring samples further apart than that say nothing of what is between them.
inline constexpr double kLongestImuStepS = 0.1;

/// Whether the samples, by the clock of the frames, say what the body did at a time.
bool Covers(const std::vector<ImuSample>& samples, int64_t t_ns);

/// So much wider than what was measured of the motion is its prior: it must not compete. At four
/// times the noise by the likelihood, gravity and the clock followed it.
inline constexpr double kFreeMotion = 100;

/// How the body turns at a time, by the gyro; nullopt where samples do not cover it.
std::optional<Eigen::Vector3d> RateAt(const std::vector<ImuSample>& samples, int64_t t_ns,
                                      const ImuBias& bias);

/// Replaces what a frame has of other measurements by what the IMU says: since the frame before
/// (ImuResidual, about the biases that that one has; without one nothing), and of the rates at the
/// frame. Where it covers the interval the frame's motion becomes kFreeMotion times what it
/// measured, the mean square of its accelerations, for a prior on acceleration of density 1. Where
/// it does not the biases alone go on, and false is returned. `samples` are the body's, by the
/// frames' clock.
bool SetImuFactors(const std::vector<ImuSample>& samples, const ImuOptions& options,
                   const ImuModel& model, const GraphFrame* before, GraphFrame* frame);

/// The same of all frames. The number of intervals that it covers.
int SetImuFactors(const ImuRecord& imu, const ImuModel& model, std::vector<GraphFrame>* frames);

/// The velocity in W of the place of the body where the IMU is.
Eigen::Vector3d VelocityOfImu(const BodyState& state, const ImuCalibration& calibration);

/// The state that the IMU carries a frame's state on to, over that preintegrated time, at whose end
/// the body turns at `omega_body`.
BodyState CarryOn(const BodyState& state, const Preintegration& motion,
                  const ImuCalibration& calibration, const Eigen::Vector3d& omega_body_radps);

ImuNoise NoiseOf(const ImuOptions& options, const ImuNoiseScale& scale);
/// The biases that a frame's acceleration holds (ImuResidual).
ImuBias BiasOf(const Acceleration& acceleration);

}  // namespace tagtwist::internal
