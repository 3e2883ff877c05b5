#include "apps/support/trace_recorder.h"

#include <algorithm>
#include <cinttypes>
#include <utility>

#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

std::string Microseconds(int64_t ns) {
  return Format("%" PRId64 ".%03" PRId64, ns / 1000, ns % 1000);
}

}  // namespace

TraceRecorder::TraceRecorder(std::function<int64_t()> now_ns)
    : now_ns_(std::move(now_ns)), start_ns_(now_ns_()) {}

// That of the thread, else one that is free, else a new one.
size_t TraceRecorder::LaneOf(std::thread::id thread) {
  for (const std::thread::id wanted : {thread, std::thread::id()}) {
    const auto lane = std::find_if(lanes_.begin(), lanes_.end(),
                                   [&](const Lane& at) { return at.thread == wanted; });
    if (lane == lanes_.end()) continue;
    lane->thread = thread;
    return static_cast<size_t>(lane - lanes_.begin());
  }
  lanes_.push_back({thread, {}});
  return lanes_.size() - 1;
}

void TraceRecorder::Begin(const char* name) {
  const std::lock_guard<std::mutex> lock(mutex_);
  const size_t index = LaneOf(std::this_thread::get_id());
  std::vector<size_t>& open = lanes_[index].open;
  open.push_back(events_.size());
  try {
    events_.push_back({name, now_ns_(), -1, index});
  } catch (...) {
    open.pop_back();
    throw;
  }
}

void TraceRecorder::End() noexcept {
  const std::lock_guard<std::mutex> lock(mutex_);
  const auto lane = std::find_if(lanes_.begin(), lanes_.end(), [](const Lane& at) {
    return at.thread == std::this_thread::get_id();
  });
  if (lane == lanes_.end() || lane->open.empty()) return;
  Event& event = events_[lane->open.back()];
  event.length_ns = now_ns_() - event.begin_ns;
  lane->open.pop_back();
  if (lane->open.empty()) lane->thread = std::thread::id();
}

std::string TraceRecorder::Json() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::string out = "{\"displayTimeUnit\":\"ms\",\"traceEvents\":[";
  const char* separator = "\n";
  for (size_t i = 0; i < lanes_.size(); ++i) {
    const std::string name = i == 0 ? "main" : Format("worker %zu", i);
    out += Format(
        "%s{\"ph\":\"M\",\"pid\":1,\"tid\":%zu,\"name\":\"thread_name\",\"args\":{\"name\":\"%s\"}"
        "}",
        separator, i + 1, name.c_str());
    separator = ",\n";
  }
  for (const Event& event : events_) {
    if (event.length_ns < 0) continue;
    out += Format("%s{\"ph\":\"X\",\"pid\":1,\"tid\":%zu,\"name\":\"%s\",\"ts\":%s,\"dur\":%s}",
                  separator, event.lane + 1, event.name,
                  Microseconds(event.begin_ns - start_ns_).c_str(),
                  Microseconds(event.length_ns).c_str());
    separator = ",\n";
  }
  return out + "\n]}\n";
}

}  // namespace tagtwist::internal
