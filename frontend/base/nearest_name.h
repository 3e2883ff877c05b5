#pragma once
#include <optional>
#include <string>
#include <vector>

namespace tagtwist::internal {

/// Letters to insert, delete, replace or exchange with their neighbour that make `a` into `b`.
size_t EditDistance(const std::string& a, const std::string& b);

/// The name that a mistyped one is nearest to: at most a third of its letters differ, and no other
/// name is as near. Capitals and underscores against hyphens do not count.
std::optional<std::string> NearestName(const std::string& typed,
                                       const std::vector<std::string>& names);

/// ": did you mean NAME?" with `prefix` before the name, or "".
std::string DidYouMean(const std::string& typed, const std::vector<std::string>& names,
                       const std::string& prefix = "");

}  // namespace tagtwist::internal
