#pragma once
#include <string>

#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// The page: one HTML file that needs no other.
std::string LivePage();

/// What a page is told first, as one JSON object: how things are called, the camera's size, the
/// map's tags; `can_record`: whether it may switch a recording.
std::string SetUpJson(const PublishedRun& run, bool can_record);

}  // namespace tagtwist::internal
