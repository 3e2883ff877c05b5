// An endless flight in which every hundred frames something happens: a short stretch of what the
// bench soak flies for a million frames.
#include "tests/support/situations/soak.h"

#include <gtest/gtest.h>

#include "estimator/window/sliding_window.h"
#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal::soak_test {
namespace {

std::string Text(const SoakScore& score) {
  std::string out = std::to_string(score.frames) + " frames, " + std::to_string(score.without) +
                    " without a state, beyond 5 sigma " + std::to_string(score.beyond);
  for (int i = 0; i < kSoakEvents; ++i) {
    out += ", " + NameOf(static_cast<SoakEvent>(i)) + " " +
           std::to_string(score.beyond_after[static_cast<size_t>(i)]);
  }
  return out;
}

TEST(Soak, SlowNoFrameEndsTheRunAndFewAreSurelyWrong) {
  constexpr int kFrames = 6000;
  SoakFlight flight(1);
  SlidingWindow window(SetUpOf(flight.setup()), flight.setup().options);
  SoakJudge judge;
  for (int i = 0; i < kFrames; ++i) {
    const SoakFrame frame = flight.Next();
    const auto output = window.Add(frame.measurement);
    ASSERT_TRUE(output) << output.error().message;
    judge.Add(frame, *output);
  }
  judge.AddLagged(window.Finish());
  SCOPED_TRACE("lag 0: " + Text(judge.current()) + "; lagged: " + Text(judge.lagged()));
  EXPECT_GT(judge.current().frames, 0.9 * kFrames);
  EXPECT_GT(judge.lagged().frames, 0.9 * kFrames);
  EXPECT_LT(judge.current().without, 0.005 * kFrames);
  EXPECT_LT(judge.lagged().without, 0.005 * kFrames);
  EXPECT_LT(judge.current().Share(), 0.01);
  EXPECT_LT(judge.lagged().Share(), 0.01);
}

}  // namespace
}  // namespace tagtwist::internal::soak_test
