#include "tests/support/situations/situations.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "bench/run_bench.h"
#include "estimator/batch/batch.h"
#include "frontend/base/option_check.h"
#include "tests/support/flights/exact_model.h"
#include "tests/support/flights/window_run.h"

DEFINE_int32(draws, 5, "Of each kind.");
DEFINE_int32(seed, 1, "Of the first draw.");
DEFINE_double(rate, 30, "Frames a second.");
DEFINE_string(kind, "", "One kind alone, by its name.");
DEFINE_bool(batch, false, "Batch, too.");

namespace tagtwist::internal {
namespace {

// Over the draws of a kind.
struct Scores {
  std::vector<SituationScore> of_draws;

  void Print(const char* name) const {
    double nees = 0, worst = 0, beyond = 0, position = 0, velocity = 0;
    size_t without = 0;
    const auto n = static_cast<double>(of_draws.size());
    for (const SituationScore& score : of_draws) {
      nees += score.nees / n;
      worst = std::max(worst, score.nees);
      beyond += score.beyond / n;
      position += std::pow(score.position_rms_m, 2) / n;
      velocity += std::pow(score.velocity_rms_mps, 2) / n;
      without += score.without;
    }
    std::printf("  %-7s NEES %8.2f (worst draw %8.2f), beyond %6.2f %%, %8.2f mm, %8.2f mm/s", name,
                nees, worst, 100 * beyond, 1e3 * std::sqrt(position), 1e3 * std::sqrt(velocity));
    std::printf(without > 0 ? ", %zu without a state\n" : "\n", without);
  }
};

Status MeasureKind(Situation situation) {
  Scores batch, current, lagged;
  for (int i = 0; i < FLAGS_draws; ++i) {
    const SituationDraw draw =
        DrawSituation(situation, static_cast<unsigned>(FLAGS_seed + i), FLAGS_rate);
    const WindowRun run = RunWindow(draw.setup, draw.measurements);
    current.of_draws.push_back(Judge(draw, run.current));
    lagged.of_draws.push_back(Judge(draw, run.lagged));
    if (!FLAGS_batch) continue;
    const auto estimate = RunBatch(SetUpOf(draw.setup), {}, draw.measurements);
    if (!estimate) return Error{NameOf(situation) + ": " + estimate.error().message};
    batch.of_draws.push_back(Judge(draw, estimate->frames));
  }
  std::printf("%s\n", NameOf(situation).c_str());
  if (FLAGS_batch) batch.Print("batch");
  current.Print("lag 0");
  lagged.Print("lagged");
  std::fflush(stdout);
  return Ok();
}

Status Measure() {
  for (const Situation situation : AllSituations()) {
    if (!FLAGS_kind.empty() && FLAGS_kind != NameOf(situation)) continue;
    if (const Status status = MeasureKind(situation); !status) return status;
  }
  return Ok();
}

Usage SituationsUsage() {
  return {
      "situations",
      "[--draws N] [--seed N] [--kind NAME] [--rate HZ] [--batch]",
      "How well a window, and a batch, hold where motion is not of one kind: rest, starts, jumps,\n"
      "gaps, phantoms, clocks. Draws of each kind, judged by the exact truth.",
      {{"The draws", {"draws", "seed", "kind", "rate", "batch"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem({CheckRange("draws", FLAGS_draws, 1, 1e6),
                           CheckRange("seed", FLAGS_seed, 0, 1e9),
                           CheckRange("rate", FLAGS_rate, 1, 2000)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  using namespace tagtwist::internal;
  return RunBench(argc, argv, SituationsUsage(), FlagProblem, Measure);
}
