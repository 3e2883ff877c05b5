#pragma once
#include <ctime>

namespace tagtwist::internal {

/// CPU time of this thread, or of the whole process, since it was made: what other programs do does
/// not count.
class CpuClock {
 public:
  explicit CpuClock(clockid_t clock = CLOCK_THREAD_CPUTIME_ID) : clock_(clock), start_(Now()) {}
  double ElapsedMs() const { return 1e3 * (Now() - start_); }

 private:
  double Now() const {
    timespec now{};
    clock_gettime(clock_, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
  }
  clockid_t clock_;
  double start_;
};

}  // namespace tagtwist::internal
