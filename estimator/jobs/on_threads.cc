#include "estimator/jobs/on_threads.h"

#include <algorithm>
#include <opencv2/core/utility.hpp>

#include "estimator/jobs/in_order.h"

namespace tagtwist {

OpenCvThreads::OpenCvThreads(int threads) : before_(cv::getNumThreads()) {
  cv::setNumThreads(std::min(threads, ResolveThreads(0)));
}

OpenCvThreads::~OpenCvThreads() { cv::setNumThreads(before_); }

ForRanges OnOpenCvThreads(int threads) {
  if (threads < 2) return InOneRange;
  return [threads](std::size_t count, const std::function<void(std::size_t, std::size_t)>& work) {
    // Several a thread: cores that are busy elsewhere are not waited for.
    const int pieces = 4 * threads;
    const auto begin = [count, pieces](int piece) {
      return count * static_cast<std::size_t>(piece) / static_cast<std::size_t>(pieces);
    };
    cv::parallel_for_(
        cv::Range(0, pieces),
        [&](const cv::Range& range) {
          for (int i = range.start; i < range.end; ++i) {
            if (begin(i) < begin(i + 1)) work(begin(i), begin(i + 1));
          }
        },
        pieces);
  };
}

}  // namespace tagtwist
