#pragma once
#include <memory>
#include <string>

#include "estimator/jobs/pieces/frame_range.h"
#include "estimator/jobs/run_options.h"
#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// What decides which corners are found: camera, map, detector, and how images are searched.
std::string SearchText(const Config& config, DetectionMode detection);

/// The table of the corners of the frames of that range (MeasuredTagsHeader), as a batch run over
/// all that `source` gives finds them.
Result<std::string> MeasureCorners(std::unique_ptr<DataSource> source, const FrameRange& range,
                                   const Config& config, const RunOptions& options);

}  // namespace tagtwist::internal
