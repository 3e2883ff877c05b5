#include <gflags/gflags.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <opencv2/core/utility.hpp>
#include <optional>

#include "bench/run_bench.h"
#include "bench/scores.h"
#include "estimator/jobs/in_order.h"
#include "estimator/jobs/progress.h"
#include "frontend/base/option_check.h"
#include "tests/support/flights/bench_flights.h"
#include "tests/support/flights/exact_model.h"

DEFINE_int32(seeds, 5, "Runs of each simulated flight, every one with noise of its own.");
DEFINE_int32(exact_runs, 200, "Runs of each exact model; 0 leaves them out.");
DEFINE_double(duration, 10, "Seconds of a simulated flight.");
DEFINE_double(corner_noise_px, 0.1, "Noise of the simulated corners, standard deviation [px].");
DEFINE_int32(threads, 0, "Runs at once; 0: as many as the machine has. The figures do not change.");

namespace tagtwist::internal {
namespace {

// A row of the table: how to make and judge its run of a seed.
struct Row {
  std::string name;
  size_t runs = 0;
  bool exact = false;  // all is as modelled, noise given: the verdict means something
  std::function<Result<RunScores>(uint64_t seed)> score;
};

Row SimulatedRow(const BenchFlight& flight) {
  Row row{flight.name, static_cast<size_t>(FLAGS_seeds), false, {}};
  row.score = [flight, duration_s = FLAGS_duration](uint64_t seed) -> Result<RunScores> {
    const Config config = DefaultConfig();
    const auto run = MakeBenchRun(flight, config, duration_s, seed);
    if (!run) return run.error();
    return ScoreRun(config.set_up, config.estimator, *run);
  };
  return row;
}

Row ExactRow(const std::string& name, const ExactModelOptions& model) {
  Row row{name, static_cast<size_t>(FLAGS_exact_runs), true, {}};
  row.score = [model](uint64_t seed) {
    ExactModelOptions drawn = model;
    drawn.random_seed = static_cast<unsigned>(seed);
    ExactModelFlight flight = DrawFlight(drawn);
    BenchRun run;
    for (size_t i = 0; i < flight.truth.size(); ++i) {
      run.truth.push_back(
          {flight.measurements[i].t_ns, flight.truth[i].world_from_body, flight.truth[i].twist});
    }
    run.measurements = std::move(flight.measurements);
    return ScoreRun(CourseSetUp(), GivenNoise(drawn), run);
  };
  return row;
}

std::vector<Row> Rows() {
  std::vector<Row> rows;
  for (const BenchFlight& flight : BenchGrid(FLAGS_corner_noise_px)) {
    rows.push_back(SimulatedRow(flight));
  }
  if (FLAGS_exact_runs > 0) {
    rows.push_back(ExactRow("exact model, jerk", ModelUnder(WhiteNoiseOn::kJerk)));
    rows.push_back(ExactRow("exact model, acceleration", ModelUnder(WhiteNoiseOn::kAcceleration)));
  }
  return rows;
}

Result<RunScores> ScoreRow(const Row& row, int threads) {
  RunScores sum;
  Progress progress(row.name, row.runs);
  const auto done = ForEachInOrder(
      row.runs, threads, [&](size_t i) { return row.score(i + 1); },
      [&](size_t i, const Result<RunScores>& run) -> Status {
        if (!run)
          return Error{row.name + ", seed " + std::to_string(i + 1) + ": " + run.error().message};
        sum += *run;
        progress.Update(i + 1);
        return Ok();
      });
  if (!done) return done.error();
  return sum;
}

void PrintRow(const std::vector<std::string>& cells) {
  constexpr std::array<int, 13> kWidths = {-26, -14, 5, 8, 8, 8, 11, 11, 5, 5, 5, 14, 6};
  for (size_t i = 0; i < cells.size(); ++i) {
    std::printf("%*s%s", kWidths[i], cells[i].c_str(), i + 1 < cells.size() ? " " : "\n");
  }
  std::fflush(stdout);
}

Status Measure(int threads) {
  PrintRow(ScoreHeader());
  std::string verdicts;
  for (const Row& row : Rows()) {
    const auto scores = ScoreRow(row, threads);
    if (!scores) return scores.error();
    const std::array<std::pair<const char*, const Score*>, 3> methods = {
        {{"batch", &scores->batch},
         {"window, lagged", &scores->lagged},
         {"window, lag 0", &scores->current}}};
    for (const auto& [method, score] : methods) {
      PrintRow(ScoreCells(row.name, method, *score));
      if (row.exact) verdicts += row.name + ", " + method + ": " + Verdict(*score) + "\n";
    }
  }
  std::printf(
      "RMSE/bound: position, attitude, velocity, rate; 1 where the printed covariance holds\n%s",
      verdicts.c_str());
  return Ok();
}

Usage AccuracyUsage() {
  return {
      "accuracy",
      "[--seeds N] [--exact_runs N] [--threads N]",
      "Monte Carlo of batch and window over a grid of flights, everything learned: RMSE against\n"
      "the exact truth, RMSE over the bound that the covariance states, NEES per degree of\n"
      "freedom. Then flights drawn from the estimator's own model with its noise given, where\n"
      "the NEES of one frame a run must lie in its chi-square band.",
      {{"How much", {"seeds", "exact_runs", "duration", "corner_noise_px"}},
       {"Running", {"threads"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem({CheckRange("seeds", FLAGS_seeds, 1, 1e6),
                           CheckRange("exact_runs", FLAGS_exact_runs, 0, 1e6),
                           CheckRange("duration", FLAGS_duration, 1, 1e4),
                           CheckRange("corner_noise_px", FLAGS_corner_noise_px, 0, 100),
                           CheckRange("threads", FLAGS_threads, 0, 256)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  cv::setNumThreads(1);  // the runs are spread over threads here
  return tagtwist::internal::RunBench(
      argc, argv, tagtwist::internal::AccuracyUsage(), tagtwist::internal::FlagProblem, [] {
        return tagtwist::internal::Measure(tagtwist::internal::ResolveThreads(FLAGS_threads));
      });
}
