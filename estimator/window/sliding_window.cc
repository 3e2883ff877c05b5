#include "estimator/window/sliding_window.h"

#include <utility>

#include "estimator/graph/graph_builder.h"
#include "estimator/window/fixed_lag_smoother.h"
#include "estimator/window/imu/window_imu.h"
#include "estimator/window/online_clock.h"
#include "estimator/window/rolling_shutter.h"
#include "estimator/window/window_systematic.h"

namespace tagtwist {

using namespace internal;

struct SlidingWindow::Impl {
  explicit Impl(const EstimatorSetup& of) : setup(of), smoother(of), clock(of) {
    if (setup.HasRollingShutter()) undo.emplace(setup);
    if (setup.options.systematic_errors) systematic.emplace(setup);
  }

  // The frame at its time; a clock that is taken in another way begins a new window.
  Result<WindowOutput> AddAtTime(const FrameMeasurements& measurement, const TimeUp& time_up) {
    if (clock_changed) smoother.LeaveForNewTimes(&left);
    clock_changed = false;
    auto out = smoother.Add(measurement, time_up);
    if (!out) return out;
    out->lagged.insert(out->lagged.begin(), left.begin(), left.end());
    left.clear();
    if (imu) imu->AddTo(measurement, smoother.noise(), &*out);
    if (systematic) systematic->AddTo(measurement, smoother.noise(), &*out);
    if (out->current.status != FrameStatus::kNoFix) {
      clock_changed = clock.Judge(smoother.noise().corner_sigma_px, measurement.tags,
                                  out->current.state.world_from_body);
    }
    return out;
  }

  // The frame with its own time, and its corners as of then.
  Result<WindowOutput> AddInTime(FrameMeasurements measurement, int64_t t_ns,
                                 const TimeUp& time_up) {
    measurement.t_ns = t_ns;
    if (!undo) return AddAtTime(measurement, time_up);
    const auto of_stamp = undo->AsOfStamp(std::move(measurement), time_up);
    return of_stamp ? AddAtTime(*of_stamp, time_up) : of_stamp.error();
  }

  Result<WindowOutput> Add(const FrameMeasurements& measurement, const TimeUp& time_up) {
    const int64_t t_ns = clock.TimeOf(measurement.t_ns);
    auto out = t_ns == measurement.t_ns && !undo ? AddAtTime(measurement, time_up)
                                                 : AddInTime(measurement, t_ns, time_up);
    if (out) clock.NameByStamp(&out->current, &out->lagged);
    return out;
  }

  EstimatorSetup setup;
  FixedLagSmoother smoother;
  OnlineClock clock;
  bool clock_changed = false;
  std::vector<FrameEstimate> left;             // when it did
  std::optional<RollingShutterUndo> undo;      // where the camera has a rolling shutter
  std::optional<WindowImu> imu;                // where there is one
  std::optional<WindowSystematic> systematic;  // where they are asked for
};

SlidingWindow::SlidingWindow(const SetUp& set_up, const EstimatorOptions& options)
    : impl_(std::make_unique<Impl>(MakeEstimatorSetup(set_up, options))) {}
SlidingWindow::SlidingWindow(SlidingWindow&&) noexcept = default;
SlidingWindow& SlidingWindow::operator=(SlidingWindow&&) noexcept = default;
SlidingWindow::~SlidingWindow() = default;

Result<WindowOutput> SlidingWindow::Add(const FrameMeasurements& measurement,
                                        const TimeUp& time_up) {
  return impl_->Add(measurement, time_up);
}

void SlidingWindow::Use(const ImuOptions& imu) { impl_->imu.emplace(impl_->setup, imu); }

void SlidingWindow::AddImu(const std::vector<ImuSample>& samples) {
  if (impl_->imu) impl_->imu->AddSamples(samples);
}

std::optional<ImuResult> SlidingWindow::Imu() const {
  return impl_->imu ? impl_->imu->found() : std::nullopt;
}

Status SlidingWindow::CheckSetUp() const { return impl_->smoother.CheckSetUp(); }

std::vector<FrameEstimate> SlidingWindow::Finish() {
  std::vector<FrameEstimate> out = impl_->smoother.Finish();
  if (impl_->imu) impl_->imu->AddTo(&out);
  if (impl_->systematic) impl_->systematic->AddTo(&out);
  impl_->clock.NameByStamp(nullptr, &out);
  return out;
}

std::optional<StateAndCovariance> SlidingWindow::PredictAt(int64_t t_ns) const {
  const auto by_imu = impl_->imu ? impl_->imu->PredictAt(t_ns) : std::nullopt;
  return by_imu ? by_imu : impl_->smoother.PredictAt(t_ns);
}

const NoiseModel& SlidingWindow::noise() const { return impl_->smoother.noise(); }

std::vector<std::string> SlidingWindow::Warnings() const {
  std::vector<std::string> out = impl_->smoother.Warnings();
  const auto of_repeated = impl_->undo ? impl_->undo->Warning() : std::nullopt;
  if (of_repeated) out.push_back(*of_repeated);
  if (const auto of_clock = impl_->clock.Warning()) out.push_back(*of_clock);
  const auto of_imu = impl_->imu ? impl_->imu->Warning() : std::nullopt;
  if (of_imu) out.push_back(*of_imu);
  return out;
}

ReprojectionErrorsByPlace SlidingWindow::Reprojection() const {
  return impl_->smoother.Reprojection();
}

std::vector<CameraShare> SlidingWindow::Cameras() const { return impl_->smoother.Cameras(); }

}  // namespace tagtwist
