#pragma once
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// The page: one HTML file that needs no other.
std::string LivePage();

/// A page with its parts, each in the place of its mark, in order.
std::string WithAssets(
    std::string_view html,
    const std::vector<std::pair<std::string_view, std::string_view>>& marks_and_parts);

/// What a page is told first, as one JSON object: how things are called, the cameras' sizes, the
/// tags of the map and of bodies; `can_record`: whether it may switch a recording.
std::string SetUpJson(const PublishedRun& run, bool can_record);

}  // namespace tagtwist::internal
