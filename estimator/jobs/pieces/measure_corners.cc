#include "estimator/jobs/pieces/measure_corners.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/progress.h"
#include "estimator/online/config_text.h"
#include "frontend/io/tables/detections_csv.h"

namespace tagtwist::internal {

std::string SearchText(const Config& config, DetectionMode detection) {
  return CameraSectionText(config) + MapSectionText(config) + DetectorSectionText(config) +
         "pieces of " + std::to_string(FramesPerPiece(config, detection)) + "\n";
}

namespace {

// The pieces that a run over all frames searches together and that have a frame of the range.
FrameRange WholePieces(const FrameRange& range, size_t per_piece, size_t frames) {
  const size_t pieces = (range.to + per_piece - 1) / per_piece;
  return {range.from / per_piece * per_piece, std::min(frames, pieces * per_piece)};
}

}  // namespace

Result<std::string> MeasureCorners(std::unique_ptr<DataSource> source, const FrameRange& range,
                                   const Config& config, const RunOptions& options) {
  const FrameRange whole =
      WholePieces(range, FramesPerPiece(config, options.detection), source->stamps_ns().size());
  const auto part = TakeRange(std::move(source), whole);
  auto stream =
      MeasurementStream::Create(part.get(), config, {false, options.threads, options.detection});
  if (!stream) return stream.error();
  std::optional<Progress> bar;
  if (options.progress) bar.emplace("measuring", range.to - range.from);
  std::string out = MeasuredTagsHeader();
  for (size_t at = whole.from; at < range.to; ++at) {
    auto found = stream->NextDetected();
    if (!found) return found.error();
    if (!*found) break;
    if (at < range.from) continue;
    out += FormatMeasuredTags((*found)->frame.t_ns, (*found)->tags, (*found)->doubled_ids);
    if (bar) bar->Update(at + 1 - range.from);
  }
  return out;
}

}  // namespace tagtwist::internal
