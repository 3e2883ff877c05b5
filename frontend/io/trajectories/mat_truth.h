#pragma once
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/mat/mat_file.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// Ground truth of a course .mat: `time` (1 x M) and `vicon` (12 x M). Empty when it has neither.
Result<std::vector<TruthSample>> TruthFromMat(MatFile* file, const std::string& path);

/// The same from a path, for a file that is wanted for its truth alone: at least one sample.
Result<std::vector<TruthSample>> ReadMatTruth(const std::string& path, const Limits& limits = {});

/// Seconds of a .mat (doubles) to nanoseconds; nullopt for what is no time.
std::optional<int64_t> NanosecondsFromMat(double seconds);

}  // namespace tagtwist::internal
