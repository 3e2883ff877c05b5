#pragma once
#include <tagtwist/estimator/evaluation/evaluation.h>

#include <cstdio>
#include <cstdlib>
#include <utility>

/// The value; or the program ends with the line that says what was wrong.
template <typename T>
T OrExit(tagtwist::Result<T> result) {
  if (result) return std::move(*result);
  std::fprintf(stderr, "%s\n", result.error().message.c_str());
  std::exit(1);
}

/// Prints how far the frames are off the truth; exit status 0 where that is less than 3 mm.
inline int Judge(const std::vector<tagtwist::FrameEstimate>& frames,
                 const std::vector<tagtwist::TruthSample>& truth) {
  const auto accuracy = OrExit(tagtwist::Evaluate(tagtwist::EstimatedSeries(frames), truth, {}));
  std::printf("%zu frames, %.2f mm RMSE\n", frames.size(), 1e3 * accuracy.position_m.rmse);
  return accuracy.position_m.rmse < 0.003 ? 0 : 1;
}
