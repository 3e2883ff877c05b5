#pragma once
#include <string>

#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// What of a configuration decides which corners are found: camera, map, detector.
std::string SearchText(const Config& config);

/// The table of the corners of all frames that `source` gives (MeasuredTagsHeader), as
/// a batch run finds them. `threads` images are searched at once; the result does not depend on it.
Result<std::string> MeasureCorners(DataSource* source, const Config& config, int threads,
                                   bool progress);

}  // namespace tagtwist::internal
