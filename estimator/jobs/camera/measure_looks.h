#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <vector>

#include "estimator/jobs/on_threads.h"
#include "frontend/base/result.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// A frame that was looked at.
struct Look {
  int64_t t_ns = 0;
  cv::Mat image;                   // empty where the corners are given
  std::vector<TagDetection> tags;  // given
};
struct Looks {
  int width = 0, height = 0;
  std::vector<Look> looks;
};

/// Finds the tags of each look by finders that `make` makes, one a thread.
template <typename Make, typename Find>
Result<std::vector<FrameMeasurements>> Measure(const std::vector<Look>& looks, int threads,
                                               const Make& make, const Find& find) {
  if (auto one = make(); !one) return one.error();
  std::vector<FrameMeasurements> out(looks.size());
  OnThreads(threads)(looks.size(), [&](size_t first, size_t last) {
    const auto finder = make();
    for (size_t i = first; i < last; ++i) {
      out[i].t_ns = looks[i].t_ns;
      if (finder) out[i].tags = find(*finder, looks[i].image);
    }
  });
  return out;
}

/// With two tags or more.
inline std::vector<FrameMeasurements> Usable(std::vector<FrameMeasurements> frames) {
  const auto too_few = [](const FrameMeasurements& frame) { return frame.tags.size() < 2; };
  frames.erase(std::remove_if(frames.begin(), frames.end(), too_few), frames.end());
  return frames;
}

}  // namespace tagtwist::internal
