#include "estimator/live/live_feed.h"

#include <algorithm>
#include <chrono>
#include <exception>
#include <limits>
#include <new>
#include <utility>

namespace tagtwist::internal {
namespace {

constexpr std::chrono::milliseconds kPatience(20);  // between looks at Options::stop

constexpr int64_t kForever = std::numeric_limits<int64_t>::max();

// Stamps may be any numbers: the sum ends where the clock does.
int64_t Sum(int64_t a_ns, int64_t b_ns) {
  int64_t out = 0;
  if (!__builtin_add_overflow(a_ns, b_ns, &out)) return out;
  return b_ns > 0 ? kForever : -kForever;
}

// What a source throws would end the process here, in a thread of its own.
Result<std::optional<Frame>> NextOf(DataSource* source) {
  try {
    return source->Next();
  } catch (const std::bad_alloc&) {
    return Error{"out of memory"};
  } catch (const std::exception& fault) {
    return Error{std::string("cannot read on: ") + fault.what()};
  }
}

}  // namespace

int64_t SteadyNowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

LiveFeed::LiveFeed(std::unique_ptr<DataSource> source, Options options)
    : source_(std::move(source)), options_(std::move(options)) {}

LiveFeed::~LiveFeed() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  changed_.notify_all();
  if (thread_.joinable()) thread_.join();
}

void LiveFeed::Capture() {
  for (bool first = true;; first = false) {
    Taken taken = NextOf(source_.get());
    const bool ended = !taken || !*taken;
    if (!ended && options_.paced) {
      const int64_t t_ns = (*taken)->t_ns;
      if (first) {
        const std::lock_guard<std::mutex> lock(mutex_);
        stamps_behind_ns_ = Sum(SteadyNowNs(), -std::max(t_ns, -kForever));
      }
      if (!WaitUntilDue(t_ns)) return;
    }
    const std::lock_guard<std::mutex> lock(mutex_);
    if (stop_) return;
    if (ended) {
      end_ = std::move(taken);
    } else {
      waiting_.Push(std::move(**taken));
    }
    changed_.notify_all();
    if (ended) return;
  }
}

// False when the feed ends meanwhile.
bool LiveFeed::WaitUntilDue(int64_t t_ns) {
  std::unique_lock<std::mutex> lock(mutex_);
  const std::chrono::steady_clock::time_point due{
      std::chrono::nanoseconds(Sum(t_ns, stamps_behind_ns_))};
  changed_.wait_until(lock, due, [this] { return stop_; });
  return !stop_;
}

Result<std::optional<Frame>> LiveFeed::Next() {
  if (!thread_.joinable()) thread_ = std::thread([this] { Capture(); });
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    if (options_.stop()) return std::optional<Frame>();
    if (auto frame = waiting_.Pop()) return frame;
    if (end_) return *end_;
    changed_.wait_for(lock, kPatience);
  }
}

double LiveFeed::AgeMs(int64_t t_ns) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const int64_t due_ns = Sum(t_ns, stamps_behind_ns_);
  return 1e-6 * (static_cast<double>(SteadyNowNs()) - static_cast<double>(due_ns));
}

size_t LiveFeed::dropped() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return waiting_.dropped();
}

}  // namespace tagtwist::internal
