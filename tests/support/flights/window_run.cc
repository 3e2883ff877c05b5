#include "tests/support/flights/window_run.h"

#include <gtest/gtest.h>

#include <utility>

#include "tests/support/flights/exact_model.h"

namespace tagtwist::internal {

WindowRun RunWindow(const EstimatorSetup& setup,
                    const std::vector<FrameMeasurements>& measurements) {
  SlidingWindow window(SetUpOf(setup), setup.options);
  WindowRun run;
  for (const FrameMeasurements& m : measurements) {
    const auto out = window.Add(m);
    EXPECT_TRUE(out) << out.error().message;
    if (!out) return run;
    run.current.push_back(out->current);
    run.lagged.insert(run.lagged.end(), out->lagged.begin(), out->lagged.end());
  }
  for (FrameEstimate& e : window.Finish()) run.lagged.push_back(std::move(e));
  return run;
}

}  // namespace tagtwist::internal
