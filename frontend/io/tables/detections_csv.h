#pragma once
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/io/tables/stamps.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// The rows of one stamp.
struct StampedDetections {
  int64_t t_ns = 0;
  int line = 0;  // of the first row, for messages
  std::vector<TagDetection> tags;
  std::vector<int> doubled_ids = {};  // of rows that tell that alone, sorted
};

/// Reads "t,id,u1,v1,...,u4,v4" (or "timestamp" in ns): corners p1..p4 in pixels, pixel centres at
/// integers. Rows of a stamp stand together and stamps grow; ids may repeat. Where `known_ids` has
/// entries, another id is an error. Rows without numbers and those whose stamps run backwards are
/// passed over, and counted in the notes.
Result<std::vector<StampedDetections>> ReadDetectionsCsv(const std::string& path, TimeUnit unit,
                                                         const std::vector<int>& known_ids = {},
                                                         std::vector<std::string>* notes = nullptr,
                                                         const Limits& limits = {});

/// Optionally the upper triangle of a tag's covariance over u1 v1 .. u4 v4, row by row, in 36
/// columns c11, c12, .., c88 [px^2]; cells may be empty. And optionally a column `doubled`: a row
/// that has 1 there has no corners, and tells that its id was seen at two places at once.
/// FormatMeasuredTags writes them all.
std::string MeasuredTagsHeader();
std::string FormatMeasuredTags(int64_t t_ns, const std::vector<TagDetection>& tags,
                               const std::vector<int>& doubled_ids);

/// The header line, and the rows of one stamp, numbers in the shortest form that reads back.
std::string DetectionsCsvHeader(TimeUnit unit);
std::string FormatDetections(int64_t t_ns, const std::vector<TagDetection>& tags, TimeUnit unit);

}  // namespace tagtwist::internal
