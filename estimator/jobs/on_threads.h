#pragma once
#include "frontend/base/for_ranges.h"

namespace tagtwist {

/// Spreads work over OpenCV's threads, as many as it has then but for these at most.
ForRanges OnOpenCvThreads(int threads);

/// While it lives, OpenCV has that many threads, no more than the machine; then as many as before.
class OpenCvThreads {
 public:
  explicit OpenCvThreads(int threads);
  ~OpenCvThreads();
  OpenCvThreads(const OpenCvThreads&) = delete;
  OpenCvThreads& operator=(const OpenCvThreads&) = delete;

 private:
  int before_;
};

}  // namespace tagtwist
