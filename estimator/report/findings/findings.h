#pragma once
#include <string>
#include <vector>

#include "estimator/result/estimate.h"
#include "estimator/result/run_facts.h"
#include "frontend/types/body_state.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Something about a run that its user should know, and what to do about it.
struct Finding {
  std::string fact;           // a sentence
  std::string advice;         // a sentence, or empty
  bool is_in_sigmas = false;  // the covariances have it: no reason to doubt them
};

/// What speaks against an estimate. What frames, stamps and covariances show is counted; what must
/// be told from chance is tested: blocks of a second count as independent, and a run without that
/// fault is accused once in a thousand families of tests (SignificantScore). A fault must also
/// matter: each test states from what size on it speaks. Without truth its tests are left out.
std::vector<Finding> Findings(const Estimate& estimate, const RunFacts& facts, const TagMap& map,
                              const std::vector<TruthSample>& truth);

/// How well the states are known by their own covariances, in words: 3-D standard deviations, in
/// the median and in all frames but a twentieth.
std::string CertaintyText(const Estimate& estimate);

/// The parts of Findings.
/// Frames with few tags or without a state, missing frames, restless stamps, states that are known
/// badly.
std::vector<Finding> FrameFindings(const Estimate& estimate, const RunFacts& facts,
                                   const TagMap& map);
/// Errors that depend on the place in the image, or on the tag; noise given that the errors belie.
std::vector<Finding> ReprojectionFindings(const Estimate& estimate);
/// Errors of lens, map and corners that last and make up most of the states' variance.
std::vector<Finding> SystematicFindings(const Estimate& estimate);
/// Constant offsets, clocks apart, covariances that do not cover the errors, outlying stretches.
std::vector<Finding> TruthFindings(const Estimate& estimate, const std::vector<TruthSample>& truth);

/// Where the flags are set, as "12.3 to 13.1 s": the longest three stretches in order of time, and
/// how many more there are. `t_s` [s] has the time of every flag, at least one of which is set.
std::string StretchesText(const std::vector<double>& t_s, const std::vector<bool>& flags);

}  // namespace tagtwist::internal
