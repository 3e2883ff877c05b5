#pragma once
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "estimator/live/newest_queue.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// Nanoseconds of the machine's steady clock.
int64_t SteadyNowNs();

/// A source whose frames come when they come: a thread takes them from another source (a camera, or
/// a recording at the speed of its stamps) and decodes them while the caller works on the one
/// before. Two frames may wait; when a third comes the older of them is dropped. It starts when the
/// first frame is asked for.
class LiveFeed : public DataSource {
 public:
  struct Options {
    bool paced = false;  // each frame comes when its stamp says, the first at once
    /// Asked often: true ends the feed as if the source had ended.
    std::function<bool()> stop = [] { return false; };
  };
  LiveFeed(std::unique_ptr<DataSource> source, Options options);
  ~LiveFeed() override;  // ends the thread, which may still wait for the camera
  LiveFeed(const LiveFeed&) = delete;
  LiveFeed& operator=(const LiveFeed&) = delete;

  Result<std::optional<Frame>> Next() override;
  const std::vector<int64_t>& stamps_ns() const override { return source_->stamps_ns(); }
  const std::vector<TruthSample>& ground_truth() const override { return source_->ground_truth(); }
  const std::vector<ImuSample>& imu() const override { return source_->imu(); }

  /// Milliseconds since the moment of a stamp.
  double AgeMs(int64_t t_ns) const;
  size_t dropped() const;

 private:
  using Taken = Result<std::optional<Frame>>;
  void Capture();
  bool WaitUntilDue(int64_t t_ns);

  std::unique_ptr<DataSource> source_;
  Options options_;
  mutable std::mutex mutex_;  // of all that follows
  std::condition_variable changed_;
  NewestQueue<Frame> waiting_{2};
  std::optional<Taken> end_;      // how the source ended
  int64_t stamps_behind_ns_ = 0;  // the clock less the stamps
  bool stop_ = false;
  std::thread thread_;  // from the first frame on that is asked for
};

}  // namespace tagtwist::internal
