#include "estimator/window/sliding_window.h"

#include <utility>

#include "estimator/graph/graph_builder.h"
#include "estimator/window/fixed_lag_smoother.h"
#include "estimator/window/rolling_shutter.h"
#include "estimator/window/window_systematic.h"

namespace tagtwist {

using namespace internal;

struct SlidingWindow::Impl {
  explicit Impl(const EstimatorSetup& setup) : smoother(setup) {
    if (setup.line_time_s != 0) undo.emplace(setup);
    if (WindowSystematic::IsAsked(setup.options)) systematic.emplace(setup);
  }

  Result<WindowOutput> Add(const FrameMeasurements& measurement, const TimeUp& time_up) {
    auto out = smoother.Add(measurement, time_up);
    if (out && systematic) systematic->AddTo(measurement, smoother.noise(), &*out);
    return out;
  }

  FixedLagSmoother smoother;
  std::optional<RollingShutterUndo> undo;      // where the camera has a rolling shutter
  std::optional<WindowSystematic> systematic;  // where any is given
};

SlidingWindow::SlidingWindow(const SetUp& set_up, const EstimatorOptions& options)
    : impl_(std::make_unique<Impl>(MakeEstimatorSetup(set_up, options))) {}
SlidingWindow::SlidingWindow(SlidingWindow&&) noexcept = default;
SlidingWindow& SlidingWindow::operator=(SlidingWindow&&) noexcept = default;
SlidingWindow::~SlidingWindow() = default;

Result<WindowOutput> SlidingWindow::Add(const FrameMeasurements& measurement,
                                        const TimeUp& time_up) {
  if (!impl_->undo) return impl_->Add(measurement, time_up);
  const auto of_stamp = impl_->undo->AsOfStamp(measurement, time_up);
  if (!of_stamp) return of_stamp.error();
  return impl_->Add(*of_stamp, time_up);
}

Status SlidingWindow::CheckSetUp() const { return impl_->smoother.CheckSetUp(); }

std::vector<FrameEstimate> SlidingWindow::Finish() {
  std::vector<FrameEstimate> out = impl_->smoother.Finish();
  if (impl_->systematic) impl_->systematic->AddTo(&out);
  return out;
}

std::optional<StateAndCovariance> SlidingWindow::PredictAt(int64_t t_ns) const {
  return impl_->smoother.PredictAt(t_ns);
}

const NoiseModel& SlidingWindow::noise() const { return impl_->smoother.noise(); }

std::vector<std::string> SlidingWindow::Warnings() const { return impl_->smoother.Warnings(); }

ReprojectionErrorsByPlace SlidingWindow::Reprojection() const {
  return impl_->smoother.Reprojection();
}

}  // namespace tagtwist
