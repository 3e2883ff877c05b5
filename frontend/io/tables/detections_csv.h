#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "frontend/io/tables/stamps.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// What a table of detections (detections_reader.h) may have besides: the upper triangle of a tag's
/// covariance over u1 v1 .. u4 v4, row by row, in 36
/// columns c11, c12, .., c88 [px^2]; cells may be empty. And optionally a column `doubled`: a row
/// that has 1 there has no corners, and tells that its id was seen at two places at once.
/// FormatMeasuredTags writes them all.
std::vector<std::string> TagCovarianceNames();
std::string MeasuredTagsHeader();
std::string FormatMeasuredTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                               const std::vector<int>& doubled_ids);

/// The header line, and the rows of one stamp, numbers in the shortest form that reads back.
std::string DetectionsCsvHeader(TimeUnit unit);
std::string FormatDetections(int64_t t_ns, const std::vector<TagDetection>& tags, TimeUnit unit);

}  // namespace tagtwist::internal
