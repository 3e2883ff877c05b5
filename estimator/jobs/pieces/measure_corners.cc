#include "estimator/jobs/pieces/measure_corners.h"

#include <optional>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/progress.h"
#include "estimator/online/config_text.h"
#include "frontend/io/tables/detections_csv.h"

namespace tagtwist::internal {

std::string SearchText(const Config& config) {
  return CameraSectionText(config) + MapSectionText(config) + DetectorSectionText(config);
}

Result<std::string> MeasureCorners(DataSource* source, const Config& config, int threads,
                                   bool progress) {
  auto stream = MeasurementStream::Create(source, config, false, threads);
  if (!stream) return stream.error();
  std::optional<Progress> bar;
  if (progress) bar.emplace("measuring", source->stamps_ns().size());
  std::string out = MeasuredTagsHeader();
  for (size_t frames = 1;; ++frames) {
    auto found = stream->NextDetected();
    if (!found) return found.error();
    if (!*found) return out;
    out += FormatMeasuredTags((*found)->frame.t_ns, (*found)->tags, (*found)->doubled_ids);
    if (bar) bar->Update(frames);
  }
}

}  // namespace tagtwist::internal
