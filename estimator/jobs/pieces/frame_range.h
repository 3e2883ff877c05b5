#pragma once
#include <cstddef>
#include <memory>
#include <optional>
#include <string>

#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// A place between the frames of a recording, whose length need not be known: after so many frames,
/// or after a share of them.
struct FrameMark {
  double value = 0;
  bool is_percent = false;
};

/// "3000" frames, or "12.5%" of them; an error says what was expected.
Result<FrameMark> ParseFrameMark(const std::string& text);

/// How many of `frames` frames lie before the mark: shares are rounded down, so that the same text
/// is the same place for whoever ends there and whoever begins there.
size_t FramesBefore(const FrameMark& mark, size_t frames);

/// Frames `from` to `to` - 1 of a recording, counted from 0.
struct FrameRange {
  size_t from = 0, to = 0;
};

/// The range between two marks (nullopt: the recording's beginning, its end), within the recording.
/// An error where it has no frame.
Result<FrameRange> RangeOf(const std::optional<FrameMark>& from, const std::optional<FrameMark>& to,
                           size_t frames);

/// The frames of that range alone, with all that the recording has besides frames.
std::unique_ptr<DataSource> TakeRange(std::unique_ptr<DataSource> source, const FrameRange& range);

}  // namespace tagtwist::internal
