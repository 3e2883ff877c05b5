#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// What a video's container says of its frames.
struct VideoTimes {
  /// Of the frames in the order in which the decoder hands them out: the stamps that they carry
  /// (frame_mark.h) where all have one, or presentation times since the stream's start; nullopt
  /// where the container has none.
  std::vector<std::optional<int64_t>> stamps_ns;
  double rate_hz = 0;            // the average that the container tells; 0: none
  int64_t announced_frames = 0;  // by the container's header; 0: it does not say
  double duration_s = 0;         // likewise
  int turn_clockwise_deg = 0;    // a player turns the images by this: 0, 90, 180 or 270
  double step_s = 0;             // times are whole steps of that
};

/// Decodes the whole file once (libavformat and libavcodec): only then is it known which frames
/// there are, and a frame keeps its own time through the decoder's reordering. A video with more
/// pixels a frame than limits.frame_pixels is refused before they are decoded.
Result<VideoTimes> ReadVideoTimes(const std::string& path, const Limits& limits = {});

/// Stamps of all frames, and what was done about those that had none or did not grow.
struct RepairedStamps {
  std::vector<int64_t> stamps_ns;  // of the frames that are kept, strictly growing
  std::vector<bool> kept;          // one a frame of the file
  size_t invented = 0;             // frames without a time, put at the usual interval
  size_t dropped = 0;              // frames whose time repeats or runs backwards
  bool by_rate = false;            // no frame had a time: all are the frame rate's
};

/// The step that the times are rounded to; 0 where they are whole intervals of the shortest, as
/// 25 Hz are in milliseconds: those are exact.
double RoundingOf(const std::vector<int64_t>& stamps_ns, double step_s);

/// Keeps the container's times. A frame without one follows its predecessor by the median interval
/// of those that have one. `times.rate_hz` is used only where no frame has a time; an error where
/// that is missing, too.
Result<RepairedStamps> RepairStamps(const VideoTimes& times);

}  // namespace tagtwist::internal
