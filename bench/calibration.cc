#include "estimator/calibration/calibration.h"

#include <gflags/gflags.h>

#include <cstdio>

#include "bench/run_bench.h"
#include "estimator/batch/batch.h"
#include "estimator/jobs/in_order.h"
#include "estimator/jobs/progress.h"
#include "frontend/base/option_check.h"
#include "frontend/base/statistics/chi_square.h"
#include "tests/support/flights/calibration_flight.h"

DEFINE_int32(seeds, 40, "Flights, every one with noise and tags of its own.");
DEFINE_int32(frames, 120, "Of a flight, at 10 Hz.");
DEFINE_double(bend_mm, 1.06, "Standard deviation of the tags' bends, which is believed, too.");
DEFINE_double(line_time_us, 0,
              "Of the rolling shutter that all flights have; believed to be 0 +- 50. 0: none.");
DEFINE_int32(threads, 0, "Runs at once; 0: as many as the machine has. The figures do not change.");

namespace tagtwist::internal {
namespace {

constexpr double kThreeSigma = 3, kLineTimeSigmaS = 5e-5;

// Squared distances of estimated poses from the exact ones, summed over the frames.
struct PoseScore {
  double position = 0, rotation = 0;
  size_t frames = 0;
};

// One flight: errors of everything but the tags' poses over their sigmas, NEES of all.
struct CalibrationScore {
  std::vector<std::string> names;
  std::vector<double> sigmas_off, bends_off;
  double nees = 0;
  int dof = 0;
  PoseScore calibrated, knowing;  // batch with the refined set-up, and with the exact one
};

Result<PoseScore> ScorePoses(const SetUp& set_up, const CalibrationFlight& flight) {
  const auto batch = RunBatch(set_up, flight.config.estimator, flight.measurements);
  if (!batch) return batch.error();
  PoseScore out;
  for (size_t i = 0; i < batch->frames.size(); ++i) {
    const Pose &estimate = batch->frames[i].state.world_from_body,
               &exact = flight.world_from_body[i];
    out.position += (estimate.translation() - exact.translation()).squaredNorm();
    out.rotation += Difference(estimate, exact).head<3>().squaredNorm();
    ++out.frames;
  }
  return out;
}

Result<CalibrationScore> ScoreSeed(unsigned seed) {
  CalibrationFlightOptions options;
  options.frames = FLAGS_frames;
  options.rate_hz = 10;
  options.random_seed = seed;
  options.tag_bend_sigma = 1e-3 * FLAGS_bend_mm / TagGrid().tag_size_m;
  options.line_time_s = 1e-6 * FLAGS_line_time_us;
  CalibrationFlight flight = DrawCalibrationFlight(options);
  if (options.line_time_s != 0) flight.config.calibration.line_time_sigma_s = kLineTimeSigmaS;
  const auto result =
      Calibrate(CalibrationInputOf(flight.config), flight.measurements, flight.ground_truth);
  if (!result) return result.error();
  CalibrationScore out;
  const Eigen::VectorXd error = Difference(result->refined, flight.truth);
  std::vector<int> free;
  for (int i = 0; i < static_cast<int>(error.size()); ++i) {
    if (!(result->prior_sigmas(i) > 0)) continue;
    free.push_back(i);
    if (i >= LayoutOf(flight.truth).tag(0)) continue;
    out.names.push_back(result->parameters[static_cast<size_t>(i)].name);
    out.sigmas_off.push_back(std::abs(error(i)) / result->sigma(i));
  }
  const CalibrationLayout layout = LayoutOf(flight.truth);
  for (int i = 0; i < layout.n_tags; ++i) {
    const int bend = layout.bend(i);
    if (!result->applied[static_cast<size_t>(bend)]) continue;
    out.bends_off.push_back(std::abs(error(bend)) / result->sigma(bend));
  }
  const Eigen::VectorXd of_free = error(free);
  const Eigen::MatrixXd covariance = result->covariance(free, free);
  out.nees = of_free.dot(covariance.ldlt().solve(of_free));
  out.dof = static_cast<int>(free.size());
  const auto calibrated = ScorePoses(result->set_up, flight);
  if (!calibrated) return calibrated.error();
  const auto knowing = ScorePoses(Apply(flight.config.set_up, flight.truth), flight);
  if (!knowing) return knowing.error();
  out.calibrated = *calibrated;
  out.knowing = *knowing;
  return out;
}

void Add(const PoseScore& of_run, PoseScore* sum) {
  sum->position += of_run.position;
  sum->rotation += of_run.rotation;
  sum->frames += of_run.frames;
}

void PrintRow(const std::string& name, const std::vector<double>& sigmas_off) {
  double within = 0, squares = 0;
  for (const double sigmas : sigmas_off) {
    within += sigmas < kThreeSigma ? 1 : 0;
    squares += sigmas * sigmas;
  }
  const auto n = static_cast<double>(sigmas_off.size());
  std::printf("%-20s %7.1f%% %10.2f\n", name.c_str(), 100 * within / n, std::sqrt(squares / n));
}

void PrintRows(const std::vector<CalibrationScore>& scores) {
  std::printf("%-20s %8s %10s\n", "parameter", "< 3 sig", "rms sigmas");
  for (size_t k = 0; k < scores.front().names.size(); ++k) {
    std::vector<double> sigmas_off;
    for (const CalibrationScore& score : scores) sigmas_off.push_back(score.sigmas_off[k]);
    PrintRow(scores.front().names[k], sigmas_off);
  }
  std::vector<double> bends_off;
  size_t applied = 0;
  for (const CalibrationScore& score : scores) {
    bends_off.insert(bends_off.end(), score.bends_off.begin(), score.bends_off.end());
    applied += score.bends_off.empty() ? 0 : 1;
  }
  if (applied > 0) PrintRow("bends of the tags", bends_off);
  std::printf("bends applied in %zu of %zu flights\n", applied, scores.size());
}

void Print(const std::vector<CalibrationScore>& scores) {
  PrintRows(scores);
  double nees = 0, dof = 0;
  PoseScore calibrated, knowing;
  for (const CalibrationScore& score : scores) {
    nees += score.nees;
    dof += score.dof;
    Add(score.calibrated, &calibrated);
    Add(score.knowing, &knowing);
  }
  const auto band = MeanChiSquareBand(dof, 1);
  std::printf(
      "NEES of all parameters with the tags: %.3f a degree of freedom, 95 %% band %.3f to "
      "%.3f\n",
      nees / dof, band.low / dof, band.high / dof);
  const auto rms = [](double sum, const PoseScore& score) {
    return std::sqrt(sum / static_cast<double>(score.frames));
  };
  const double mm = 1e3 * rms(calibrated.position, calibrated),
               knowing_mm = 1e3 * rms(knowing.position, knowing);
  const double mrad = 1e3 * rms(calibrated.rotation, calibrated),
               knowing_mrad = 1e3 * rms(knowing.rotation, knowing);
  std::printf(
      "poses, RMSE: %.3f mm, %.3f mrad; with the exact set-up %.3f mm, %.3f mrad: times "
      "%.2f, %.2f\n",
      mm, mrad, knowing_mm, knowing_mrad, mm / knowing_mm, mrad / knowing_mrad);
}

Status Measure(int threads) {
  std::vector<CalibrationScore> scores;
  Progress progress("calibration", static_cast<size_t>(FLAGS_seeds));
  const auto done = ForEachInOrder(
      static_cast<size_t>(FLAGS_seeds), threads,
      [](size_t i) { return ScoreSeed(static_cast<unsigned>(i + 1)); },
      [&](size_t i, Result<CalibrationScore> score) -> Status {
        if (!score) return Error{"seed " + std::to_string(i + 1) + ": " + score.error().message};
        scores.push_back(std::move(*score));
        progress.Update(i + 1);
        return Ok();
      });
  if (!done) return done;
  Print(scores);
  return Ok();
}

Usage CalibrationUsage() {
  return {"calibration",
          "[--seeds N] [--frames N] [--bend_mm B] [--line_time_us U] [--threads N]",
          "Monte Carlo of --calibrate: flights whose focal length, principal point, distortion,\n"
          "mount, print scale, clock, tags and their bends are all wrong at once, against ground "
          "truth.",
          {{"How much", {"seeds", "frames", "bend_mm", "line_time_us"}}, {"Running", {"threads"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem({CheckRange("seeds", FLAGS_seeds, 1, 1e6),
                           CheckRange("frames", FLAGS_frames, 20, 1e6),
                           CheckRange("bend_mm", FLAGS_bend_mm, 0, 30),
                           CheckRange("line_time_us", FLAGS_line_time_us, -1e3, 1e3),
                           CheckRange("threads", FLAGS_threads, 0, 256)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::RunBench(
      argc, argv, tagtwist::internal::CalibrationUsage(), tagtwist::internal::FlagProblem, [] {
        return tagtwist::internal::Measure(tagtwist::internal::ResolveThreads(FLAGS_threads));
      });
}
