#include "estimator/motion/motion_banks.h"

#include <algorithm>
#include <cmath>

#include "frontend/types/so3.h"

namespace tagtwist::internal {

MotionBanks::MotionBanks(WhiteNoiseOn linear, WhiteNoiseOn angular)
    : MotionBanks(LinearBankOptions(linear), AngularBankOptions(angular)) {}

MotionBanks::MotionBanks(const MotionBankOptions& linear, const MotionBankOptions& angular)
    : linear_(linear), angular_(angular), before_(weights()) {}

MotionBanks::Densities MotionBanks::DensitiesOf(const Weights& weights) const {
  return {linear_.DensityOf(weights.linear), angular_.DensityOf(weights.angular)};
}

// The reference turns as the mean does; what the classes know of the attitude turns with it.
void MotionBanks::PredictBy(double dt_s) {
  linear_.Predict(dt_s);
  const MotionBank::State mean = angular_.Mean();
  const Eigen::Vector3d turn = mean.segment<3>(3) * dt_s + 0.5 * dt_s * dt_s * mean.segment<3>(6);
  angular_.TurnOrigin(ExpSo3(-turn).toRotationMatrix());
  angular_.Predict(dt_s);
  const Eigen::Vector3d moved = angular_.Mean().head<3>();
  angular_.MoveOrigin(moved);
  reference_ = MakePose(reference_.rotation() * ExpSo3(moved), reference_.translation());
}

void MotionBanks::Predict(int64_t t_ns) {
  if (is_measured()) PredictBy(std::abs(ToSeconds(t_ns - last_ns_)));
  last_ns_ = t_ns;
  before_ = weights();
}

void MotionBanks::Measure(const PoseMeasurement& pose) {
  const Pose& measured = pose.world_from_body;
  if (!is_measured()) reference_ = measured;
  linear_.Measure(measured.translation(), pose.position_covariance);
  angular_.Measure(LogSo3(reference_.rotation().conjugate() * measured.rotation()),
                   pose.attitude_covariance);
  const Eigen::Vector3d off = angular_.Mean().head<3>();
  angular_.MoveOrigin(off);
  reference_ = MakePose(reference_.rotation() * ExpSo3(off), measured.translation());
  ++n_measured_;
}

PartLikelihoods MotionBanks::log_likelihoods() const {
  if (n_measured_ < 2) return {};
  return {linear_.log_likelihood(), angular_.log_likelihood()};
}

void MotionBanks::SetWeights(const Weights& weights) {
  linear_.SetWeights(weights.linear);
  angular_.SetWeights(weights.angular);
}

void MotionBanks::SetDensities(const Densities& densities) {
  linear_.SetLeastDensity(densities.linear);
  angular_.SetLeastDensity(densities.angular);
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
  MotionBankOptions of_linear = LinearBankOptions(linear.on),
                    of_angular = AngularBankOptions(angular.on);
  of_linear.classes = of_angular.classes = 1;
  of_linear.least_density = linear.psd;
  of_angular.least_density = angular.psd;
  return {of_linear, of_angular};
}

MotionHistory::MotionHistory(const NoiseModel& noise)
    : banks_(noise.linear.on, noise.angular.on),
      fresh_(banks_),
      rivals_{{1, UnderOneDensity(noise.linear, noise.angular)},
              {0.1, UnderOneDensity(noise.linear, noise.angular)}} {}

void MotionHistory::Compare(const MotionBanks::Densities& densities, const Frame& frame) {
  static constexpr double kFade = 1 - 1.0 / 100, kMost = 40;
  const PartLikelihoods bank = banks_.log_likelihoods();
  const auto part = [](double advantage, double by) {
    return std::clamp(kFade * advantage + by, -kClearly, kMost);
  };
  for (Rival& rival : rivals_) {
    rival.single.SetDensities({rival.share * densities.linear, rival.share * densities.angular});
    rival.single.Predict(frame.t_ns);
    rival.single.Measure(*frame.pose);
    const PartLikelihoods single = rival.single.log_likelihoods();
    rival.advantage = {part(rival.advantage.linear, bank.linear - single.linear),
                       part(rival.advantage.angular, bank.angular - single.angular)};
  }
}

bool MotionHistory::LinearVaries() const {
  return std::all_of(rivals_.begin(), rivals_.end(),
                     [](const Rival& rival) { return rival.advantage.linear > kClearly; });
}

bool MotionHistory::AngularVaries() const {
  return std::all_of(rivals_.begin(), rivals_.end(),
                     [](const Rival& rival) { return rival.advantage.angular > kClearly; });
}

void MotionHistory::Add(const EstimatorSetup& setup, const NoiseModel& noise,
                        const GraphFrame& frame) {
  Frame out{frame.t_ns,
            PoseOfTags(setup, noise.corner_sigma_px, frame.tags, frame.state.world_from_body),
            {},
            {}};
  if (out.pose && !out.pose->is_consensus) out.pose.reset();
  if (out.pose) {
    banks_.Predict(frame.t_ns);
    banks_.Measure(*out.pose);
    Compare({noise.linear.psd, noise.angular.psd}, out);
  }
  out.before = banks_.weights_before();
  out.after = banks_.weights();
  frames_.push_back(std::move(out));
}

PartLikelihoods MotionHistory::Likelihoods(MotionBanks bank) const {
  PartLikelihoods out;
  for (const Frame& frame : frames_) {
    if (!frame.pose) continue;
    bank.Predict(frame.t_ns);
    bank.Measure(*frame.pose);
    out.linear += bank.log_likelihoods().linear;
    out.angular += bank.log_likelihoods().angular;
  }
  return out;
}

std::vector<MotionBanks::Densities> MotionHistory::FromBothSides() const {
  std::vector<MotionBanks::Densities> out(frames_.size());
  MotionBanks backwards = fresh_;
  backwards.SetWeights(banks_.weights());  // the future goes on as the present is
  for (size_t k = frames_.size(); k-- > 0;) {
    const Frame& frame = frames_[k];
    if (k + 1 < frames_.size()) {
      const Frame& end = frames_[k + 1];  // of the interval that begins here
      if (frame.pose) {
        backwards.Predict(frame.t_ns);
        backwards.Measure(*frame.pose);
      }
      const MotionBanks::Weights later = backwards.weights();
      out[k + 1] = banks_.DensitiesOf(
          {WeightsFromBothSides(end.after.linear, end.before.linear, later.linear),
           WeightsFromBothSides(end.after.angular, end.before.angular, later.angular)});
    } else if (frame.pose) {
      backwards.Predict(frame.t_ns);
      backwards.Measure(*frame.pose);
    }
  }
  if (!out.empty()) out[0] = out.size() > 1 ? out[1] : banks_.densities();
  return out;
}

}  // namespace tagtwist::internal
