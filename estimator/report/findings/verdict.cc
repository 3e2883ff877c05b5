#include "estimator/report/findings/verdict.h"

#include <algorithm>

#include "frontend/base/format_text.h"
#include "frontend/base/ratio_statistic.h"

namespace tagtwist::internal {
namespace {

constexpr double kLeastS = RatioStatistic::kLeastBlocks;  // blocks of a second

bool HasItsState(const FrameEstimate& frame) { return frame.status != FrameStatus::kNoFix; }

// Seconds of frames with a state that lie in the truth's time.
double JudgedByTruth(const Estimate& estimate, const std::vector<TruthSample>& truth) {
  int64_t first_ns = 0, last_ns = 0;
  bool any = false;
  for (const FrameEstimate& frame : estimate.frames) {
    if (!HasItsState(frame) || frame.t_ns < truth.front().t_ns || frame.t_ns > truth.back().t_ns) {
      continue;
    }
    if (!any) first_ns = frame.t_ns;
    last_ns = frame.t_ns;
    any = true;
  }
  return ToSeconds(last_ns - first_ns);
}

// What no test could find, in words; empty where all could.
std::string TooShort(const Estimate& estimate, const std::vector<TruthSample>& truth) {
  std::string out;
  if (estimate.reprojection.squares.blocks() < RatioStatistic::kLeastBlocks) {
    out = Format("lens, map and corner noise (%zu s with tags",
                 estimate.reprojection.squares.blocks());
  }
  if (!truth.empty() && JudgedByTruth(estimate, truth) < kLeastS) {
    out += (out.empty() ? "" : "), ") +
           Format("errors against truth (%.1f s of it", JudgedByTruth(estimate, truth));
  }
  return out.empty() ? out : out + Format("; %.0f s are the least)", kLeastS);
}

// A fact without its full stop.
std::string Clause(std::string fact) {
  while (!fact.empty() && fact.back() == '.') fact.pop_back();
  return fact;
}

}  // namespace

std::string VerdictText(const Estimate& estimate, const std::vector<Finding>& findings,
                        const std::vector<TruthSample>& truth,
                        const std::vector<std::string>& doubts) {
  if (std::none_of(estimate.frames.begin(), estimate.frames.end(), HasItsState)) {
    return "there is no estimate: no frame has a state.";
  }
  const std::string too_short = TooShort(estimate, truth);
  const std::string rest = too_short.empty() ? "" : " It was too short to judge " + too_short + ".";
  std::vector<std::string> against = doubts;
  for (const Finding& finding : findings) {
    if (!finding.is_in_sigmas) against.push_back(finding.fact);
  }
  if (!against.empty()) {
    return "not to be relied on as it is: " + Clause(against.front()) +
           (against.size() > 1 ? Format(" (and %zu more).", against.size() - 1) : ".") + rest;
  }
  if (!too_short.empty()) {
    return "nothing speaks against it, but it was too short to judge " + too_short + ".";
  }
  std::string out = "to be relied on within its sigmas: nothing speaks against it";
  if (truth.empty()) out += ", as far as that can be seen without ground truth";
  return out + (findings.empty() ? "." : ". Worth a look: " + findings.front().fact);
}

}  // namespace tagtwist::internal
