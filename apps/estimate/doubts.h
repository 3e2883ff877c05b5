#pragma once
#include <string>
#include <vector>

#include "apps/estimate/estimate_flags.h"
#include "apps/estimate/inputs.h"
#include "estimator/jobs/tag_sample.h"
#include "frontend/base/fault.h"

namespace tagtwist::internal {

/// Mistakes in the set-up that a run, done or failed, gives away.
using Doubts = std::vector<Fault>;

/// What cannot be, what single mistake explains the corners, which tags the images show instead,
/// and what is wrong with the truth as a whole. `estimate`: nullptr of a run that ended with
/// `error`.
Doubts DoubtsOf(const EstimateJob& job, const Config& config, const TagSample& sample,
                const std::vector<TruthSample>& truth, const Estimate* estimate,
                const std::string& error);

/// A fault in one line.
std::string TextOf(const Fault& fault);

/// A run's error, with what may have caused it.
Error WithDoubts(const Error& error, const Inputs& inputs, const Doubts& doubts);

}  // namespace tagtwist::internal
