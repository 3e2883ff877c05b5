#include "estimator/live/live_feed.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>

namespace tagtwist::internal::live_feed_test {
namespace {

constexpr int64_t kMsNs = 1000000;

// Frames at 0, interval, 2 interval, ...
class Metronome : public DataSource {
 public:
  Metronome(int frames, int64_t interval_ns) : frames_(frames), interval_ns_(interval_ns) {}
  Result<std::optional<Frame>> Next() override {
    if (next_ == frames_) return std::optional<Frame>();
    Frame frame;
    frame.t_ns = interval_ns_ * next_++;
    return std::optional<Frame>(frame);
  }
  const std::vector<int64_t>& stamps_ns() const override { return none_; }

 private:
  int frames_, next_ = 0;
  int64_t interval_ns_;
  std::vector<int64_t> none_;
};

class Broken : public Metronome {
 public:
  Broken() : Metronome(0, 1) {}
  Result<std::optional<Frame>> Next() override { return Error{"rec: broken"}; }
};

LiveFeed::Options Paced() {
  LiveFeed::Options options;
  options.paced = true;
  return options;
}

// Nothing is early; of what nobody was slow for nothing is dropped, unless the machine stood still.
TEST(LiveFeed, FramesComeWhenTheirStampsSay) {
  LiveFeed feed(std::make_unique<Metronome>(10, 20 * kMsNs), Paced());
  const int64_t start_ns = SteadyNowNs();
  size_t got = 0;
  int64_t last_ns = -1;
  while (true) {
    const auto frame = feed.Next();
    ASSERT_TRUE(frame);
    if (!*frame) break;
    EXPECT_GT((*frame)->t_ns, last_ns);
    last_ns = (*frame)->t_ns;
    EXPECT_GE(SteadyNowNs() - start_ns, last_ns);
    EXPECT_GE(feed.AgeMs(last_ns), 0);
    ++got;
  }
  EXPECT_EQ(last_ns, 180 * kMsNs);
  EXPECT_EQ(got + feed.dropped(), 10u);
}

TEST(LiveFeed, ASlowCallerHasTheNewestAndTheRestIsCounted) {
  LiveFeed feed(std::make_unique<Metronome>(20, 5 * kMsNs), Paced());
  ASSERT_TRUE(*feed.Next());
  std::this_thread::sleep_for(std::chrono::milliseconds(300));
  std::vector<int64_t> rest;
  while (true) {
    const auto frame = feed.Next();
    if (!*frame) break;
    rest.push_back((*frame)->t_ns);
  }
  EXPECT_EQ(rest, (std::vector<int64_t>{90 * kMsNs, 95 * kMsNs}));
  EXPECT_EQ(feed.dropped(), 17u);
}

TEST(LiveFeed, EndsWhenItIsTold) {
  std::atomic<bool> stop = false;
  LiveFeed::Options options = Paced();
  options.stop = [&] { return stop.load(); };
  LiveFeed feed(std::make_unique<Metronome>(1000, 1000 * kMsNs), options);
  ASSERT_TRUE(*feed.Next());
  stop = true;
  const auto frame = feed.Next();
  ASSERT_TRUE(frame);
  EXPECT_FALSE(*frame);
}  // and its thread ends here, not in a quarter of an hour

TEST(LiveFeed, AnErrorComesThrough) {
  LiveFeed feed(std::make_unique<Broken>(), Paced());
  const auto frame = feed.Next();
  ASSERT_FALSE(frame);
  EXPECT_EQ(frame.error().message, "rec: broken");
}

}  // namespace
}  // namespace tagtwist::internal::live_feed_test
