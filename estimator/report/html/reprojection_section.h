#pragma once
#include "estimator/report/html/page.h"
#include "estimator/result/estimate.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Section "Reprojection": histogram of the corners' distances from their predictions, the same by
/// place in the image and by tag.
ReportSection ReprojectionSection(const Estimate& estimate, const TagMap& map);

/// The image in cells as SVG: each cell's RMS error in figures and colour, its mean error as an
/// arrow from its centre. Empty where there are no errors.
std::string ImageErrorsSvg(const ReprojectionErrorsByPlace& errors);

/// A row a tag, a bar whenever it was in use, over the time since t0_ns as SVG. Empty without tags.
std::string TagsOverTimeSvg(const ReprojectionErrorsByPlace& errors, int64_t t0_ns);

}  // namespace tagtwist::internal
