#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace tagtwist::internal {

/// What a Matroska block carries beside its image (BlockAdditional 1): the stamp that the
/// container's milliseconds would round, as text, "t_ns=1000000001".
std::string FrameMark(int64_t t_ns);

/// The stamp of such a text; nullopt where it is another's, or no stamp.
std::optional<int64_t> ReadFrameMark(std::string_view text);

}  // namespace tagtwist::internal
