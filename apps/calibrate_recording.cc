#include "apps/calibrate_recording.h"

#include <utility>

#include "apps/measurement_stream.h"
#include "apps/progress.h"

namespace tagtwist {

Result<Calibration> CalibrateRecording(const std::string& dataset, DataSource* source,
                                       const Config& config, const RunOptions& options,
                                       const std::vector<TruthSample>& truth) {
  auto stream = MeasurementStream::Create(source, config, options.use_detections, options.threads);
  if (!stream) return stream.error();
  std::vector<FrameMeasurements> measurements;
  {
    Progress progress("calibrating", source->stamps_ns().size());
    while (true) {
      auto next = stream->Next();
      if (!next) return next.error();
      if (!*next) break;
      measurements.push_back(std::move((*next)->measurements));
      measurements.back().tracks = {};
      progress.Update(measurements.size());
    }
  }
  auto calibration = Calibrate(config, measurements, truth);
  if (!calibration) return Error{dataset + ": " + calibration.error().message};
  return calibration;
}

}  // namespace tagtwist
