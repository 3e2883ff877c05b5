#pragma once
#include <string>

#include "estimator/publish/json_text.h"
#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// Digits of numbers, those of states.csv and covariance.csv.
inline constexpr int kStateDigits = 10, kSigmaDigits = 7, kCovarianceDigits = 12;

/// {"sec": ..., "nsec": ...} of a stamp, nsec in [0, 1e9).
void AppendStamp(int64_t t_ns, JsonText* json);

/// x y z w of an attitude, w >= 0.
Eigen::Vector4d QuaternionOf(const Pose& pose);

/// A frame's state as one JSON object, SI units, order and frames as states.csv and covariance.csv:
/// docs/formats.md has its keys. What belongs to the state is null where there is none.
std::string StateJson(const PublishedRun& run, const PublishedFrame& frame);

/// The JSON schema of that object.
std::string StateSchema();

}  // namespace tagtwist::internal
