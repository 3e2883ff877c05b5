#include "estimator/motion/bank/motion_banks.h"

#include <algorithm>
#include <cmath>

#include "estimator/motion/bank/interval_classes.h"
#include "frontend/types/so3.h"

namespace tagtwist::internal {

MotionBanks::MotionBanks(const MotionPrior& linear, const MotionPrior& angular)
    : MotionBanks(LinearBankOptions(linear.on), AngularBankOptions(angular.on)) {
  SetShakes(linear.shake_s, angular.shake_s);
}

MotionBanks::MotionBanks(const MotionBankOptions& linear, const MotionBankOptions& angular)
    : linear_(linear), angular_(angular) {}

MotionBanks::Prediction MotionBanks::prediction() const {
  constexpr double kLeastWeight = 1e-5;
  return {linear_.Classes(kLeastWeight), angular_.Classes(kLeastWeight), reference_, dt_s_};
}

MotionBanks::Densities MotionBanks::DensitiesAfter(const Prediction& past) const {
  constexpr double kLeastWeight = 1e-4, kKeepS = 30;
  const double keep = std::exp(-past.dt_s / kKeepS);
  const auto of = [keep](const std::vector<MotionBank::Class>& before, const MotionBank& after,
                         const Eigen::Vector3d& origin) {
    return after.DensityOf(WeightsFromBothSides(before,
                                                InForwardTime(after.Classes(kLeastWeight), origin),
                                                after.options().on, keep, after.size()));
  };
  const Pose& then = past.reference;
  Densities out;
  if (follows_.linear) out.linear = of(past.linear, linear_, Eigen::Vector3d::Zero());
  if (follows_.angular) {
    out.angular =
        of(past.angular, angular_, LogSo3(then.rotation().conjugate() * reference_.rotation()));
  }
  return out;
}

// The reference turns as the mean does; what the classes know of the attitude turns with it.
void MotionBanks::PredictBy(double dt_s) {
  if (follows_.linear) linear_.Predict(dt_s);
  if (!follows_.angular) return;
  const MotionBank::State mean = angular_.Mean();
  const Eigen::Vector3d turn = mean.segment<3>(3) * dt_s + 0.5 * dt_s * dt_s * mean.segment<3>(6);
  angular_.TurnOrigin(ExpSo3(-turn).toRotationMatrix());
  angular_.Predict(dt_s);
  const Eigen::Vector3d moved = angular_.Mean().head<3>();
  angular_.MoveOrigin(moved);
  reference_ = MakePose(reference_.rotation() * ExpSo3(moved), reference_.translation());
}

void MotionBanks::Predict(int64_t t_ns) {
  dt_s_ = std::abs(ToSeconds(t_ns - last_ns_));
  if (is_measured()) PredictBy(dt_s_);
  last_ns_ = t_ns;
}

void MotionBanks::Measure(const PoseMeasurement& pose) {
  const Pose& measured = pose.world_from_body;
  if (!is_measured()) reference_ = measured;
  ++n_measured_;
  if (follows_.linear) linear_.Measure(measured.translation(), pose.position_covariance);
  if (!follows_.angular) return;
  angular_.Measure(LogSo3(reference_.rotation().conjugate() * measured.rotation()),
                   pose.attitude_covariance);
  const Eigen::Vector3d off = angular_.Mean().head<3>();
  angular_.MoveOrigin(off);
  reference_ = MakePose(reference_.rotation() * ExpSo3(off), measured.translation());
}

PartLikelihoods MotionBanks::log_likelihoods() const {
  if (n_measured_ < 2) return {};
  return {linear_.log_likelihood(), angular_.log_likelihood()};
}

void MotionBanks::SetWeights(const Weights& weights) {
  linear_.SetWeights(weights.linear);
  angular_.SetWeights(weights.angular);
}

void MotionBanks::SetShakes(double linear_s, double angular_s) {
  linear_.SetShake(linear_s);
  angular_.SetShake(angular_s);
}

StateVector MotionBanks::ExcessVariances() const {
  const Eigen::Vector2d linear = linear_.ExcessVariance(), angular = angular_.ExcessVariance();
  StateVector out;
  out.segment<3>(0).setConstant(angular(0));
  out.segment<3>(3).setConstant(linear(0));
  out.segment<3>(6).setConstant(linear(1));
  out.segment<3>(9).setConstant(angular(1));
  return out;
}

MotionBanks UnderOneDensity(const MotionPrior& linear, const MotionPrior& angular) {
  const auto one = [](MotionBankOptions options, const MotionPrior& prior) {
    options.classes = 1;
    options.shake_s = prior.shake_s;
    options.least_density = prior.psd;
    return options;
  };
  return {one(LinearBankOptions(linear.on), linear), one(AngularBankOptions(angular.on), angular)};
}

}  // namespace tagtwist::internal
