#include "tests/support/situations/soak.h"

#include <gflags/gflags.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <optional>
#include <string>

#include "bench/run_bench.h"
#include "estimator/jobs/progress.h"
#include "estimator/window/sliding_window.h"
#include "frontend/base/option_check.h"
#include "tests/support/flights/exact_model.h"

DEFINE_int32(frames, 1000000, "How many.");
DEFINE_int32(seed, 1, "Of all that happens.");

namespace tagtwist::internal {
namespace {

// Resident memory of this process [MiB].
double ResidentMiB() {
  std::ifstream file("/proc/self/statm");
  double size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

void Print(const char* name, const SoakScore& score) {
  std::printf("%-7s %zu frames, %zu with two tags and no state; beyond 5 sigma %.3f %%:", name,
              score.frames, score.without, 100 * score.Share());
  for (int i = 0; i < kSoakEvents; ++i) {
    std::printf(" %s %zu%s", NameOf(static_cast<SoakEvent>(i)).c_str(),
                score.beyond_after[static_cast<size_t>(i)], i + 1 < kSoakEvents ? "," : "\n");
  }
}

Status Measure() {
  SoakFlight flight(static_cast<unsigned>(FLAGS_seed));
  SlidingWindow window(SetUpOf(flight.setup()), flight.setup().options);
  SoakJudge judge;
  Progress progress("estimating", static_cast<size_t>(FLAGS_frames));
  double most_mib = 0;
  const auto print = [&](int frames) {
    std::printf("%9d frames, %.1f MiB, %.1f at most between\n", frames, ResidentMiB(), most_mib);
    std::fflush(stdout);
    most_mib = 0;
  };
  for (int i = 0; i < FLAGS_frames; ++i) {
    const SoakFrame frame = flight.Next();
    const auto output = window.Add(frame.measurement);
    if (!output) return Error{"frame " + std::to_string(i) + ": " + output.error().message};
    judge.Add(frame, *output);
    if ((i + 1) % 1000 == 0) most_mib = std::max(most_mib, ResidentMiB());
    if ((i + 1) % std::max(1, FLAGS_frames / 10) == 0) print(i + 1);
    progress.Update(static_cast<size_t>(i + 1));
  }
  judge.AddLagged(window.Finish());
  std::printf("exits: 0\n");
  Print("lag 0", judge.current());
  Print("lagged", judge.lagged());
  for (const std::string& warning : window.Warnings()) std::printf("%s\n", warning.c_str());
  return Ok();
}

Usage SoakUsage() {
  return {"soak",
          "[--frames N] [--seed N]",
          "Whether a window lives through all that happens: every hundred frames of a flight\n"
          "without end there is rest, a start, a gap, a burst of phantoms, bent corners, a step\n"
          "of the clock, a kidnapping, or a spin. Prints whether it ended, its memory, and the\n"
          "share of states beyond 5 sigma, by what happened last.",
          {{"The flight", {"frames", "seed"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem(
      {CheckRange("frames", FLAGS_frames, 1000, 1e9), CheckRange("seed", FLAGS_seed, 0, 1e9)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  using namespace tagtwist::internal;
  return RunBench(argc, argv, SoakUsage(), FlagProblem, Measure);
}
