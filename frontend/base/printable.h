#pragma once
#include <string>
#include <string_view>

namespace tagtwist::internal {

/// The text with a question mark for each control character, of ASCII and (in UTF-8) of Latin-1:
/// what a file says may hold line ends, and sequences that a terminal obeys.
std::string Printable(std::string_view text);

}  // namespace tagtwist::internal
