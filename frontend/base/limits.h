#pragma once
#include <cstdint>

namespace tagtwist::internal {

/// What a file may ask for at most. Whatever asks for more is refused before the memory or the time
/// is spent; recordings that are meant to be larger get Times(factor) of it.
struct Limits {
  int64_t file_bytes = 2'000'000'000;  // of a table, a trajectory or an image that is read whole
  int64_t text_bytes = 20'000'000;     // of YAML or XML, whose trees are larger than they are
  int64_t pipe_bytes = 200'000'000;    // of a pipe, which does not tell how much is to come
  double pipe_idle_s = 5;              // that a pipe may say nothing
  int64_t frame_pixels = 100'000'000;  // of an image or a frame of a video

  Limits Times(double factor) const {
    Limits out = *this;
    for (int64_t* bound : {&out.file_bytes, &out.text_bytes, &out.pipe_bytes, &out.frame_pixels}) {
      *bound = static_cast<int64_t>(factor * static_cast<double>(*bound));
    }
    out.pipe_idle_s *= factor;
    return out;
  }
};

}  // namespace tagtwist::internal
