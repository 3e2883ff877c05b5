#include "residuals/preintegration.h"

#include <algorithm>

#include "frontend/types/so3.h"

namespace tagtwist::internal {
namespace {

using Iterator = std::vector<ImuSample>::const_iterator;

// The first sample that is later.
Iterator After(const std::vector<ImuSample>& samples, int64_t t_ns) {
  return std::upper_bound(
      samples.begin(), samples.end(), t_ns,
      [](int64_t stamp_ns, const ImuSample& sample) { return stamp_ns < sample.t_ns; });
}

// Both at steady rate and force over a step.
void Step(const Eigen::Vector3d& gyro, const Eigen::Vector3d& accel, const ImuNoise& noise,
          double dt_s, Preintegration* out) {
  const Eigen::Vector3d turn = dt_s * (gyro - out->bias.gyro_radps);
  const Eigen::Vector3d force = accel - out->bias.accel_mps2;
  const Eigen::Matrix3d middle = (out->rotation * ExpSo3(0.5 * turn)).toRotationMatrix();
  Eigen::Matrix<double, 9, 9> a = Eigen::Matrix<double, 9, 9>::Identity();
  Eigen::Matrix<double, 9, 6> b = Eigen::Matrix<double, 9, 6>::Zero();
  const Eigen::Quaterniond over = ExpSo3(turn);
  a.block<3, 3>(0, 0) = over.toRotationMatrix().transpose();
  a.block<3, 3>(3, 0) = -dt_s * middle * Hat(force);
  a.block<3, 3>(6, 0) = 0.5 * dt_s * a.block<3, 3>(3, 0);
  a.block<3, 3>(6, 3).diagonal().setConstant(dt_s);
  b.block<3, 3>(0, 0) = dt_s * RightJacobianSo3(turn);
  b.block<3, 3>(3, 3) = dt_s * middle;
  b.block<3, 3>(6, 3) = 0.5 * dt_s * dt_s * middle;
  Eigen::Matrix<double, 6, 1> variances;
  variances << Eigen::Vector3d::Constant(noise.gyro * noise.gyro / dt_s),
      Eigen::Vector3d::Constant(noise.accel * noise.accel / dt_s);
  out->covariance = (a * out->covariance * a.transpose()).eval();
  out->covariance += b * variances.asDiagonal() * b.transpose();
  out->by_bias = (a * out->by_bias).eval() - b;
  const Eigen::Vector3d gained = dt_s * (middle * force);
  out->position_m += dt_s * (out->velocity_mps + 0.5 * gained);
  out->velocity_mps += gained;
  out->rotation = (out->rotation * over).normalized();
  out->dt_s += dt_s;
}

}  // namespace

std::optional<ImuSample> ImuAt(const std::vector<ImuSample>& samples, int64_t t_ns,
                               double longest_step_s) {
  const auto after = After(samples, t_ns);
  if (after == samples.begin()) return std::nullopt;
  const ImuSample& a = *(after - 1);
  if (a.t_ns == t_ns) return a;
  if (after == samples.end()) return std::nullopt;
  const double step_s = ToSeconds(after->t_ns - a.t_ns);
  if (step_s > longest_step_s) return std::nullopt;
  const double share = ToSeconds(t_ns - a.t_ns) / step_s;
  return ImuSample{t_ns, (1 - share) * a.accel_mps2 + share * after->accel_mps2,
                   (1 - share) * a.gyro_radps + share * after->gyro_radps};
}

std::optional<Preintegration> Preintegrate(const std::vector<ImuSample>& samples, int64_t from_ns,
                                           int64_t to_ns, const ImuBias& bias,
                                           const ImuNoise& noise, double longest_step_s) {
  const auto first = ImuAt(samples, from_ns, longest_step_s);
  const auto last = ImuAt(samples, to_ns, longest_step_s);
  if (!first || !last || to_ns <= from_ns) return std::nullopt;
  Preintegration out;
  out.bias = bias;
  ImuSample before = *first;
  const auto step_to = [&](const ImuSample& sample) {
    const double dt_s = ToSeconds(sample.t_ns - before.t_ns);
    if (dt_s > 0) {
      Step(0.5 * (before.gyro_radps + sample.gyro_radps),
           0.5 * (before.accel_mps2 + sample.accel_mps2), noise, dt_s, &out);
    }
    before = sample;
    return dt_s <= longest_step_s;
  };
  for (auto sample = After(samples, from_ns); sample != samples.end() && sample->t_ns < to_ns;
       ++sample) {
    if (!step_to(*sample)) return std::nullopt;
  }
  if (!step_to(*last)) return std::nullopt;
  return out;
}

}  // namespace tagtwist::internal
