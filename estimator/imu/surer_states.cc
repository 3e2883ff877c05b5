#include "estimator/imu/surer_states.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>

namespace tagtwist::internal {
namespace {

// The logarithm of a covariance's determinant; none is larger than of what is no covariance.
double LogDet(const StateCovariance& covariance) {
  const Eigen::LLT<StateCovariance> llt(covariance);
  if (llt.info() != Eigen::Success) return std::numeric_limits<double>::infinity();
  return 2 * llt.matrixLLT().diagonal().array().log().sum();
}

// Two measurements of the rates whose errors have next to nothing in common: by_tags' are the
// corners' over many frames, those of by_both its gyro's. The rest of the state stays. Not where
// the gyro's are the better ones: what tags and prior say of real recordings is often surer than
// it is right, and there is less to gain.
void TakeRates(const FrameEstimate& by_tags, FrameEstimate* by_both) {
  const Eigen::Matrix3d of_tags = by_tags.covariance.bottomRightCorner<3, 3>(),
                        of_both = by_both->covariance.bottomRightCorner<3, 3>();
  if (of_tags.trace() > of_both.trace()) return;
  const Eigen::Matrix3d gain = (of_tags + of_both).ldlt().solve(of_both).transpose();
  Eigen::Vector3d& rates = by_both->state.twist.omega_body;
  rates += gain * (by_tags.state.twist.omega_body - rates);
  StateCovariance kept = StateCovariance::Identity();
  kept.bottomRightCorner<3, 3>() -= gain;
  by_both->covariance = (kept * by_both->covariance * kept.transpose()).eval();
  by_both->covariance.bottomRightCorner<3, 3>() += gain * of_tags * gain.transpose();
}

}  // namespace

bool SurerStates::Agree(const FrameEstimate& by_tags, const FrameEstimate& by_both) {
  // A degree of freedom: what chance exceeds once in 1e5 frames or less often, for a frame of the
  // gyro's rates among many that are a hundred times better would be worse than all of these.
  constexpr double kMostOfOne = 4, kMostOfFew = 3, kMostOfMany = 1.7, kCounts = 10;
  const StateVector d = Difference(by_both.state, by_tags.state);
  const StateCovariance both = by_tags.covariance + by_both.covariance;
  const Eigen::Vector3d rates = d.tail<3>();
  const double of_rates = rates.dot(both.bottomRightCorner<3, 3>().ldlt().solve(rates)) / 3;
  const double of_all = d.dot(both.ldlt().solve(d)) / static_cast<double>(d.size());
  if (!std::isfinite(of_rates) || !std::isfinite(of_all)) return false;
  for (Misfit* misfit : {&of_few_, &of_many_}) {
    misfit->mean += (std::min(of_rates, kCounts) - misfit->mean) / misfit->frames;
  }
  return of_all < kMostOfOne && of_few_.mean < kMostOfFew && of_many_.mean < kMostOfMany;
}

bool SurerStates::Choose(const FrameEstimate& by_tags, FrameEstimate* by_both) {
  if (by_tags.status != FrameStatus::kOk) return false;
  if (!Agree(by_tags, *by_both)) return false;
  FrameEstimate with_rates = *by_both;
  TakeRates(by_tags, &with_rates);
  const bool are_surer = LogDet(by_tags.covariance) < LogDet(with_rates.covariance);
  *by_both = are_surer ? by_tags : with_rates;
  return are_surer;
}

}  // namespace tagtwist::internal
