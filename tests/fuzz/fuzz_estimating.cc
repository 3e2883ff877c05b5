#include "tests/fuzz/fuzz_estimating.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <set>
#include <string>

#include "estimator/batch/batch.h"
#include "estimator/online/config.h"
#include "estimator/window/sliding_window.h"
#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {
namespace {

std::optional<double> Maybe(FuzzBytes* in, double low_exponent, double high_exponent) {
  if (in->Below(3) != 0) return std::nullopt;
  return std::pow(10, in->Between(low_exponent, high_exponent));
}

void PromiseSound(const FrameEstimate& frame) {
  Promise(std::set<std::string>{"ok", "hurried", "predicted", "ambiguous", "no_fix"}.count(
              ToString(frame.status)) == 1,
          "a status without a name");
  if (frame.status == FrameStatus::kNoFix) return;
  Promise(frame.state.world_from_body.params.allFinite(), "a pose without a number");
  Promise(frame.state.twist.v_world.allFinite() && frame.state.twist.omega_body.allFinite(),
          "a twist without a number");
  Promise(frame.covariance.allFinite(), "a covariance without a number");
  const StateVector sigmas = frame.covariance.diagonal().cwiseSqrt();
  Promise(sigmas.allFinite() && (sigmas.array() > 0).all(), "a variance that is not positive");
  StateCovariance correlation = frame.covariance;
  correlation.array() /= (sigmas * sigmas.transpose()).array();
  Promise((correlation - correlation.transpose()).cwiseAbs().maxCoeff() < 1e-6,
          "a covariance that is not symmetric");
  const StateCovariance lifted = correlation + 1e-9 * StateCovariance::Identity();
  Promise(lifted.llt().info() == Eigen::Success, "a covariance that is not positive");
}

bool RunWindow(const EstimatorOptions& options, const std::vector<FrameMeasurements>& frames) {
  SlidingWindow window(CourseSetUpOnce(), options);
  for (const FrameMeasurements& frame : frames) {
    const auto out = window.Add(frame);
    if (!IsTaken(out)) return false;
    Promise(out->current.t_ns == frame.t_ns, "the answer for another frame");
    PromiseSound(out->current);
    for (const FrameEstimate& lagged : out->lagged) PromiseSound(lagged);
  }
  const auto ahead = window.PredictAt(frames.back().t_ns + 30'000'000);
  if (ahead) Promise(ahead->covariance.allFinite(), "a prediction without a number");
  IsTaken(window.CheckSetUp());
  for (const FrameEstimate& frame : window.Finish()) PromiseSound(frame);
  window.Warnings();
  return true;
}

}  // namespace

const SetUp& CourseSetUpOnce() {
  static const SetUp set_up = DefaultConfig().set_up;
  return set_up;
}

EstimatorOptions TakeOptions(FuzzBytes* in) {
  EstimatorOptions out;
  out.corner_sigma_px = Maybe(in, -3, 2);
  out.track_sigma_px = Maybe(in, -3, 2);
  out.accel_psd = Maybe(in, -6, 6);
  out.angular_accel_psd = Maybe(in, -6, 6);
  out.jerk_psd = Maybe(in, -6, 6);
  out.angular_jerk_psd = Maybe(in, -6, 6);
  out.motion_prior = static_cast<MotionPriorChoice>(in->Below(3));
  out.clock = static_cast<ClockChoice>(in->Below(3));
  out.use_tracks = in->Below(2) == 1;
  out.max_tracks_per_frame = static_cast<int>(in->Below(20));
  out.track_segment_frames = 2 + static_cast<int>(in->Below(5));
  out.robust_scale = std::pow(10, in->Between(-2, 3));
  out.window_frames = 2 + static_cast<int>(in->Below(8));
  out.max_iterations = 1 + static_cast<int>(in->Below(10));
  out.window_iterations = 1 + static_cast<int>(in->Below(5));
  return out;
}

OptionalApart<Eigen::Matrix<double, 8, 8>> TakeCovariance(FuzzBytes* in) {
  if (in->Below(3) != 0) return std::nullopt;
  Eigen::Matrix<double, 8, 1> common, own;
  for (int i = 0; i < 8; ++i) {
    own(i) = std::pow(10, in->Between(-4, 2));
    common(i) = in->Between(-1, 1);
  }
  return Eigen::Matrix<double, 8, 8>(common * common.transpose() * own.mean() +
                                     Eigen::Matrix<double, 8, 8>(own.asDiagonal()));
}

bool EstimatesSoundly(const EstimatorOptions& options,
                      const std::vector<FrameMeasurements>& frames) {
  const bool taken = RunWindow(options, frames);
  const auto batch = RunBatch(CourseSetUpOnce(), options, frames);
  if (!IsTaken(batch)) return taken;
  Promise(batch->frames.size() == frames.size(), "frames that got lost");
  for (const FrameEstimate& frame : batch->frames) PromiseSound(frame);
  return true;
}

}  // namespace tagtwist::internal
