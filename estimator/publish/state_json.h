#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "estimator/publish/json_text.h"
#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// Digits of numbers, those of states.csv and covariance.csv.
inline constexpr int kStateDigits = 10, kSigmaDigits = 7, kCovarianceDigits = 12;

/// {"sec": ..., "nsec": ...} of a stamp, nsec in [0, 1e9).
void AppendStamp(int64_t t_ns, JsonText* json);

/// x y z w of an attitude, w >= 0.
Eigen::Vector4d QuaternionOf(const Pose& pose);

/// A body's state as one JSON object, SI units, order and frames as states.csv and covariance.csv:
/// docs/live.md has its keys. What belongs to the state is null where there is none.
std::string StateJson(const PublishedRun& run, const PublishedFrame& frame, size_t body = 0);

/// Those of all bodies, in order.
std::vector<std::string> StateJsons(const PublishedRun& run, const PublishedFrame& frame);

/// The JSON schema of that object.
std::string StateSchema();

}  // namespace tagtwist::internal
