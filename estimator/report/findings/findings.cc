#include "estimator/report/findings/findings.h"

#include <algorithm>
#include <cmath>

#include "estimator/result/run_tally.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/base/units.h"

namespace tagtwist::internal {
namespace {

[[gnu::format(printf, 4, 0)]] std::string KnownTo(const std::vector<FrameEstimate>& frames,
                                                  int first, double unit, const char* format) {
  std::vector<double> sigmas;
  for (const FrameEstimate& f : frames) {
    if (f.status == FrameStatus::kNoFix) continue;
    sigmas.push_back(unit * std::sqrt(f.covariance.diagonal().segment<3>(first).sum()));
  }
  return Format(format, Quantile(sigmas, 0.5), Quantile(sigmas, 0.95));
}

// How far the frames agree among themselves, which is better than each alone is right.
std::string LastingText(const SystematicShare& s) {
  if (!(s.position_m > 0)) return "";
  return Format(
      " In that are errors of lens, map and corners that last, %.2g mm and %.2g deg (RMS); of "
      "them %.2g mm and %.2g deg are the same in all frames, which no difference between frames "
      "has.",
      1e3 * s.position_m, kDegreesPerRadian * s.rotation_rad, 1e3 * s.common_position_m,
      kDegreesPerRadian * s.common_rotation_rad);
}

}  // namespace

std::string StretchesText(const std::vector<double>& t_s, const std::vector<bool>& flags) {
  StretchTally tally;
  for (size_t i = 0; i < flags.size(); ++i) tally.Add(t_s[i], flags[i]);
  return tally.Text();
}

std::string CertaintyText(const Estimate& e) {
  const auto has_state = [](const FrameEstimate& f) { return f.status != FrameStatus::kNoFix; };
  if (std::none_of(e.frames.begin(), e.frames.end(), has_state)) return "";
  return "By its own account (one standard deviation, 3-D; the median frame, and what 95 % stay "
         "below) it knows position to " +
         KnownTo(e.frames, 3, 1e3, "%.2g (%.2g) mm") + ", attitude to " +
         KnownTo(e.frames, 0, kDegreesPerRadian, "%.2g (%.2g) deg") + ", velocity to " +
         KnownTo(e.frames, 6, 1, "%.2g (%.2g) m/s") + " and rates to " +
         KnownTo(e.frames, 9, 1, "%.2g (%.2g) rad/s") + "." + LastingText(e.systematic);
}

std::vector<Finding> Findings(const Estimate& estimate, const RunFacts& facts, const TagMap& map,
                              const std::vector<TruthSample>& truth) {
  std::vector<Finding> out = FrameFindings(estimate, facts, map);
  for (const std::vector<Finding>& part :
       {ReprojectionFindings(estimate), SystematicFindings(estimate),
        TruthFindings(estimate, truth)}) {
    out.insert(out.end(), part.begin(), part.end());
  }
  return out;
}

}  // namespace tagtwist::internal
