#pragma once
#include <cstdint>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "frontend/base/spans.h"

namespace tagtwist::internal {

/// Keeps when work began and how long it took, 32 bytes a span. Threads that work at the same time
/// have a lane each; one that begins when another is done takes its lane.
class TraceRecorder : public SpanObserver {
 public:
  /// `now_ns`: a clock that does not go back.
  explicit TraceRecorder(std::function<int64_t()> now_ns);

  void Begin(const char* name) override;
  void End() noexcept override;

  /// The spans that have ended, as complete events ("ph": "X") of Chrome's trace-event format, an
  /// event a line, in the order of their beginnings; stamps in microseconds since this was made.
  /// A lane is a "tid", the first named main, the others worker 1, 2, ...
  /// Source: Trace Event Format, JSON object form (Google, 2016).
  std::string Json() const;

 private:
  struct Event {
    const char* name;
    int64_t begin_ns, length_ns;  // -1: it has not ended
    size_t lane;
  };
  struct Lane {
    std::thread::id thread;    // none: it is free
    std::vector<size_t> open;  // events, the last begun last
  };

  size_t LaneOf(std::thread::id thread);

  std::function<int64_t()> now_ns_;
  int64_t start_ns_;
  mutable std::mutex mutex_;
  std::vector<Event> events_;  // guarded by the mutex, as is
  std::vector<Lane> lanes_;
};

}  // namespace tagtwist::internal
