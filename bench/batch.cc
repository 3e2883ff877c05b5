#include "estimator/batch/batch.h"

#include <gflags/gflags.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>

#include "bench/cpu_clock.h"
#include "bench/plain_ceres.h"
#include "bench/run_bench.h"
#include "estimator/graph/noise_model.h"
#include "estimator/jobs/on_threads.h"
#include "estimator/solve/smoother.h"
#include "estimator/start/recording_start.h"
#include "frontend/base/option_check.h"
#include "frontend/base/statistics/quantile.h"
#include "tests/support/flights/bench_flights.h"

DEFINE_double(duration, 17.65, "Seconds of the flight, 49 frames each.");
DEFINE_double(corner_noise_px, 0.3, "Noise of the corners, standard deviation [px].");
DEFINE_int32(repeat, 5, "Times every method runs, in turn; the table has the medians.");
DEFINE_int32(threads, 2, "Of the last row.");
DEFINE_int32(seed, 1, "Of everything random.");

namespace tagtwist::internal {
namespace {

// A method's times, and how far its states are off.
struct Row {
  std::string name;
  std::function<Result<std::vector<BodyState>>()> run;  // nothing to judge: no states
  std::vector<double> cpu_ms = {}, wall_ms = {};
  double position_m = 0, velocity_mps = 0;  // RMSE
};

Status RunOnce(const std::vector<TruthSample>& truth, Row* row) {
  const auto start = std::chrono::steady_clock::now();
  const CpuClock clock(CLOCK_PROCESS_CPUTIME_ID);
  const auto states = row->run();
  row->cpu_ms.push_back(clock.ElapsedMs());
  const std::chrono::duration<double, std::milli> wall = std::chrono::steady_clock::now() - start;
  row->wall_ms.push_back(wall.count());
  if (!states) return states.error();
  double position = 0, velocity = 0;
  for (size_t i = 0; i < states->size(); ++i) {
    const StateVector d = Difference((*states)[i], {truth[i].world_from_body, *truth[i].twist});
    position += d.segment<3>(3).squaredNorm();
    velocity += d.segment<3>(6).squaredNorm();
  }
  const auto n = static_cast<double>(truth.size());
  row->position_m = std::sqrt(position / n);
  row->velocity_mps = std::sqrt(velocity / n);
  return Ok();
}

std::vector<BodyState> StatesOf(const std::vector<FrameEstimate>& frames) {
  std::vector<BodyState> out;
  for (const FrameEstimate& frame : frames) out.push_back(frame.state);
  return out;
}

std::vector<BodyState> StatesOf(const std::vector<GraphFrame>& frames) {
  std::vector<BodyState> out;
  for (const GraphFrame& frame : frames) out.push_back(frame.state);
  return out;
}

// The options with these densities and this corner noise given.
EstimatorOptions Given(const EstimatorOptions& options, const NoiseModel& noise) {
  EstimatorOptions out = options;
  out.corner_sigma_px = noise.corner_sigma_px;
  const auto give = [](const MotionPrior& prior, std::optional<double>* accel,
                       std::optional<double>* jerk) {
    (prior.on == WhiteNoiseOn::kJerk ? *jerk : *accel) = prior.psd;
  };
  give(noise.linear, &out.accel_psd, &out.jerk_psd);
  give(noise.angular, &out.angular_accel_psd, &out.angular_jerk_psd);
  return out;
}

// What the batch takes and how well it does with these options.
Row BatchRow(const std::string& name, const SetUp& set_up, const EstimatorOptions& options,
             const BenchRun& flight, const ForRanges& for_ranges = InOneRange) {
  return {name, [set_up, options, for_ranges, &flight]() -> Result<std::vector<BodyState>> {
            BatchEstimator batch(set_up, options, for_ranges);
            for (const FrameMeasurements& m : flight.measurements) batch.Add(m);
            const auto result = batch.Solve();
            if (!result) return result.error();
            return StatesOf(result->frames);
          }};
}

Row StartsRow(const EstimatorSetup& setup, const BenchRun& flight) {
  return {"starts of all frames", [&]() -> Result<std::vector<BodyState>> {
            const auto starts = StartFrames(setup, flight.measurements);
            if (!starts) return starts.error();
            return StatesOf(*starts);
          }};
}

Row PlainRow(const EstimatorSetup& setup, const NoiseModel& noise,
             const std::vector<GraphFrame>& starts) {
  return {"plain Ceres", [&setup, noise, &starts]() -> Result<std::vector<BodyState>> {
            std::vector<GraphFrame> frames = starts;
            if (!SolvePlainly(setup, noise, &frames)) return Error{"plain Ceres found no solution"};
            return StatesOf(frames);
          }};
}

Row SolveRow(const std::string& name, const EstimatorSetup& setup, const NoiseModel& noise,
             const std::vector<GraphFrame>& starts) {
  return {name, [&setup, noise, &starts]() -> Result<std::vector<BodyState>> {
            GraphInput input;
            input.frames = starts;
            const auto solution =
                SolveAndInvert(setup, noise, input, {setup.options.max_iterations});
            if (!solution) return solution.error();
            TakeStates(solution->graph, &input.frames);
            return StatesOf(input.frames);
          }};
}

void Print(const std::vector<Row>& rows, double reference_ms) {
  std::printf("%-52s %9s %8s %9s %9s %9s\n", "", "CPU ms", "x ref", "wall ms", "pos. mm",
              "vel. mm/s");
  for (const Row& row : rows) {
    const double ms = Quantile(row.cpu_ms, 0.5);
    std::printf("%-52s %9.1f %8.2f %9.1f %9.3f %9.2f\n", row.name.c_str(), ms, ms / reference_ms,
                Quantile(row.wall_ms, 0.5), 1e3 * row.position_m, 1e3 * row.velocity_mps);
  }
}

Status Measure() {
  const Config config = DefaultConfig();
  const auto flight = MakeBenchRun(BenchGrid(FLAGS_corner_noise_px).front(), config, FLAGS_duration,
                                   static_cast<uint64_t>(FLAGS_seed));
  if (!flight) return flight.error();
  EstimatorOptions options = config.estimator;
  options.clock = ClockChoice::kStamps;  // the simulator's stamps are exact
  const EstimatorSetup setup = MakeEstimatorSetup(config.set_up, options);
  EstimatorOptions on_acceleration = options;
  on_acceleration.motion_prior = MotionPriorChoice::kAcceleration;
  const auto starts = StartFrames(setup, flight->measurements);
  if (!starts) return starts.error();
  const auto learned = RunBatch(config.set_up, options, flight->measurements);
  const auto constant_velocity = RunBatch(config.set_up, on_acceleration, flight->measurements);
  if (!learned) return learned.error();
  if (!constant_velocity) return constant_velocity.error();

  std::vector<Row> rows = {
      PlainRow(setup, constant_velocity->noise, *starts),
      SolveRow("tagtwist, same graph: solve + covariance", setup, constant_velocity->noise,
               *starts),
      SolveRow("tagtwist, white jerk: solve + covariance", setup, learned->noise, *starts),
      StartsRow(setup, *flight),
      BatchRow("tagtwist batch, all but files, noise given", config.set_up,
               Given(options, learned->noise), *flight),
      BatchRow("tagtwist batch, all but files, noise learned", config.set_up, options, *flight),
      BatchRow("the same, by the threads", config.set_up, options, *flight,
               OnThreads(FLAGS_threads))};
  for (int i = 0; i < FLAGS_repeat; ++i) {
    for (Row& row : rows) {
      if (const auto ran = RunOnce(flight->truth, &row); !ran) return ran;
    }
  }
  size_t tags = 0;
  for (const FrameMeasurements& m : flight->measurements) tags += m.tags.size();
  std::printf("%zu frames, %.1f corners each; median of %d runs\n", flight->truth.size(),
              4.0 * static_cast<double>(tags) / static_cast<double>(flight->truth.size()),
              FLAGS_repeat);
  Print(rows, Quantile(rows.front().cpu_ms, 0.5));
  return Ok();
}

Usage BatchUsage() {
  return {"batch",
          "[--duration S] [...]",
          "What a batch takes from corners on, beside the same problem in plain Ceres (automatic\n"
          "differentiation, one residual block a corner, no covariance) from the same starts.",
          {{"The flight", {"duration", "corner_noise_px", "seed"}},
           {"Running", {"repeat", "threads"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem({CheckRange("duration", FLAGS_duration, 1, 3600),
                           CheckRange("corner_noise_px", FLAGS_corner_noise_px, 0, 10),
                           CheckRange("repeat", FLAGS_repeat, 1, 1000),
                           CheckRange("threads", FLAGS_threads, 1, 256),
                           CheckRange("seed", FLAGS_seed, 0, 1e9)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::RunBench(argc, argv, tagtwist::internal::BatchUsage(),
                                      tagtwist::internal::FlagProblem, tagtwist::internal::Measure);
}
