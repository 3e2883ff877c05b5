#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "estimator/report/findings/comparison_table.h"
#include "estimator/report/html/page.h"
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// Slots of ReportPage that the curves of the bound have.
struct BoundSlots {
  size_t frame_alone = 0, optimised = 0, lagged = 0;
};

/// Section "Bound": what each frame's tags allow alone beside what the whole estimate reaches, in
/// words (what a better camera or more tags would bring), as a table and as curves of the 3-D
/// standard deviations over the frames. `t_s` has the time of every frame; `rows` as
/// CompareMethods gives them.
ReportSection BoundSection(const Estimate& estimate, const std::vector<ComparisonRow>& rows,
                           const std::vector<double>& t_s, const BoundSlots& slots);

}  // namespace tagtwist::internal
