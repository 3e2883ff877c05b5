#include "estimator/jobs/calibrate_recording.h"

#include <utility>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/on_threads.h"
#include "estimator/jobs/progress.h"
#include "estimator/online/calibration_input.h"

namespace tagtwist::internal {

Result<std::vector<FrameMeasurements>> MeasureRecording(const std::string& label,
                                                        DataSource* source, const Config& config,
                                                        const RunOptions& options) {
  auto stream =
      MeasurementStream::Create(source, config, {options.use_detections, options.threads});
  if (!stream) return stream.error();
  std::vector<FrameMeasurements> out;
  Progress progress(label, source->stamps_ns().size());
  while (true) {
    auto next = stream->Next();
    if (!next) return next.error();
    if (!*next) break;
    out.push_back(std::move((*next)->measurements));
    out.back().tracks = {};
    progress.Update(out.size());
  }
  return out;
}

Result<Calibration> CalibrateRecording(const std::string& dataset, DataSource* source,
                                       const Config& config, const RunOptions& options,
                                       const std::vector<TruthSample>& truth) {
  if (!config.set_up.rig.IsOneOnTheBody()) {
    return Error{dataset + ": lens and map are calibrated by one camera on the body"};
  }
  const auto measurements = MeasureRecording("calibrating", source, config, options);
  if (!measurements) return measurements.error();
  auto calibration = Calibrate(CalibrationInputOf(config), *measurements, truth);
  if (!calibration) return Error{dataset + ": " + calibration.error().message};
  return calibration;
}

Result<RigCalibration> CalibrateRigRecording(const std::string& dataset, DataSource* source,
                                             const Config& config, const RunOptions& options) {
  const auto measurements = MeasureRecording("calibrating", source, config, options);
  if (!measurements) return measurements.error();
  const CalibrationOptions& o = config.calibration;
  auto found =
      CalibrateRig(config.set_up, config.estimator,
                   {o.mount_rotation_sigma_rad, o.mount_position_sigma_m, o.time_offset_sigma_s},
                   *measurements, OnThreads(options.threads));
  if (!found) return Error{dataset + ": " + found.error().message};
  return found;
}

}  // namespace tagtwist::internal
