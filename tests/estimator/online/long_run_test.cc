// A run of many frames: what it keeps, tells and says at its end.
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/jobs/online_run.h"
#include "estimator/report/files/states_csv.h"
#include "estimator/report/result_rows.h"
#include "estimator/report/result_writer.h"
#include "estimator/result/run_tally.h"
#include "tests/support/flights/simulated_flight.h"
#include "tests/support/temp_folder.h"

namespace tagtwist::internal::long_run_test {
namespace {

constexpr size_t kLap = 98;  // frames there, and as many back

// Corners of a flight there and back again, for as long as is wanted.
class Laps : public DataSource {
 public:
  explicit Laps(size_t frames) : frames_(frames), flight_(SimulateCorners("figure8", 2)) {}

  Result<std::optional<Frame>> Next() override {
    if (next_ == frames_) return std::optional<Frame>();
    const size_t phase = next_ % (2 * kLap - 2);
    Frame frame;
    frame.t_ns = static_cast<int64_t>(20'408'163) * static_cast<int64_t>(next_++);
    frame.detections = flight_.measurements[phase < kLap ? phase : 2 * kLap - 2 - phase].tags;
    return std::optional<Frame>(std::move(frame));
  }
  const std::vector<int64_t>& stamps_ns() const override { return none_; }

 private:
  size_t frames_, next_ = 0;
  SimulatedFlight flight_;
  std::vector<int64_t> none_;
};

RunOptions OfCorners() {
  RunOptions out;
  out.sliding_window = out.use_detections = true;
  out.progress = false;
  return out;
}

Config WithSmallWindow() {
  Config out = DefaultConfig();
  out.estimator.window_frames = 4;
  out.estimator.use_tracks = out.estimator.systematic_errors = false;
  return out;
}

Result<RunResult> RunAll(OnlineRun* run) {
  while (true) {
    const auto state = run->Next();
    if (!state) return state.error();
    if (*state == nullptr) return run->Finish();
  }
}

TEST(LongRun, KeepsSomeFramesEvenlySpreadAndCountsAll) {
  constexpr size_t kFrames = 300, kMost = 64;
  Laps source(kFrames), again(kFrames);
  RunOptions options = OfCorners();
  auto whole = OnlineRun::Create("laps", &source, WithSmallWindow(), options);
  ASSERT_TRUE(whole);
  const auto all = RunAll(&*whole);
  ASSERT_TRUE(all) << all.error().message;
  EXPECT_FALSE(all->facts.all);
  EXPECT_FALSE(all->facts.totals);
  ASSERT_EQ(all->estimate.frames.size(), kFrames);
  options.most_kept = kMost;
  auto long_run = OnlineRun::Create("laps", &again, WithSmallWindow(), options);
  ASSERT_TRUE(long_run);
  const auto some = RunAll(&*long_run);
  ASSERT_TRUE(some) << some.error().message;

  const std::vector<FrameEstimate>& kept = some->estimate.frames;
  ASSERT_LT(kept.size(), kMost);
  ASSERT_GE(2 * kept.size(), kMost);
  const size_t stride = (kFrames + kept.size() - 1) / kept.size();
  ASSERT_EQ(some->estimate.lagged.size(), kept.size());
  ASSERT_EQ(some->facts.times.frame_ms.size(), kept.size());
  for (size_t i = 0; i < kept.size(); ++i) {
    EXPECT_EQ(FormatStatesRow(kept[i]), FormatStatesRow(all->estimate.frames[stride * i]));
    EXPECT_EQ(some->estimate.lagged[i].t_ns, kept[i].t_ns);
  }
  ASSERT_TRUE(some->facts.all);
  const FrameTally counted = TallyOf(some->estimate, some->facts.all.get()).frames,
                   plain = TallyOf(all->estimate).frames;
  EXPECT_EQ(counted.frames, kFrames);
  EXPECT_EQ(counted.with_state, plain.with_state);
  EXPECT_EQ(counted.velocity_changes, plain.velocity_changes);
  EXPECT_EQ(counted.last_ns, all->estimate.frames.back().t_ns);
  EXPECT_EQ(some->facts.totals->frame.count, kFrames);
}

TEST(LongRun, MemoryDoesNotGrowWithIt) {
  if (mallinfo2().uordblks == 0) GTEST_SKIP() << "malloc is not the C library's";
  constexpr size_t kFirst = 400, kFrames = 1200;
  const TempFolder temp;
  Laps source(kFrames);
  auto rows = ResultRows::Begin(temp / "out", {true, true, {""}});
  ASSERT_TRUE(rows) << rows.error().message;
  RunOptions options = OfCorners();
  options.most_kept = 64;
  options.on_state = [&](size_t body, const FrameEstimate& f) { return (*rows)->Add(body, f); };
  options.on_lagged = [&](size_t body, const FrameEstimate& f) {
    return (*rows)->AddLagged(body, f);
  };
  auto run = OnlineRun::Create("laps", &source, WithSmallWindow(), options);
  ASSERT_TRUE(run);
  for (size_t i = 0; i < kFirst; ++i) ASSERT_TRUE(run->Next());
  const size_t settled = mallinfo2().uordblks;
  for (size_t i = kFirst; i < kFrames; ++i) ASSERT_TRUE(run->Next());
  constexpr size_t kSlack = 512 * 1024;  // files' rows that wait, and frames that are kept
  EXPECT_LT(mallinfo2().uordblks, settled + kSlack);
}

}  // namespace
}  // namespace tagtwist::internal::long_run_test
