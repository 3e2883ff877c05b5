#include <gflags/gflags.h>

#include <cmath>
#include <cstdio>
#include <numeric>
#include <opencv2/core/utility.hpp>
#include <optional>

#include "bench/online.h"
#include "bench/run_bench.h"
#include "estimator/jobs/in_order.h"
#include "estimator/jobs/progress.h"
#include "frontend/base/option_check.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/simulation/named_flights.h"

DEFINE_string(trajectory, "figure8", "Of the flight: as tagtwist_simulate's.");
DEFINE_double(duration, 12, "Seconds of it.");
DEFINE_double(height, 1.2, "Its height over the mat [m].");
DEFINE_double(rate, 49, "Frames a second.");
DEFINE_double(scale, 1, "Pixels of the camera along a side, as a multiple of the course's.");
DEFINE_double(exposure_ms, 2, "Motion blur [ms].");
DEFINE_double(noise, 3, "Sensor noise, standard deviation [grey levels].");
DEFINE_int32(seed, 1, "Of everything random.");
DEFINE_int32(threads, 0,
             "Frames rendered at once; 0: as many as the machine has. What is measured "
             "runs on one.");

namespace tagtwist::internal {
namespace {

// The course's camera and mat, with more pixels or fewer.
Config ScaledConfig(double scale) {
  Config config = DefaultConfig();
  Camera& camera = config.set_up.rig.front().camera;
  camera.width = static_cast<int>(camera.width * scale);
  camera.height = static_cast<int>(camera.height * scale);
  camera.fx *= scale;
  camera.fy *= scale;
  camera.cx = scale * (camera.cx + 0.5) - 0.5;
  camera.cy = scale * (camera.cy + 0.5) - 0.5;
  return config;
}

Result<std::vector<SimulatedFrame>> RenderFlight(const Config& config) {
  FlightOptions flight;
  flight.duration_s = FLAGS_duration;
  flight.height_m = FLAGS_height;
  const auto path = FlightPath(FLAGS_trajectory, config.set_up.map, flight);
  if (!path) return path.error();
  StampOptions stamp_options;
  stamp_options.rate_hz = FLAGS_rate;
  const auto stamps_ns = MakeStamps(path->first_ns(), path->last_ns(), stamp_options);
  if (!stamps_ns) return stamps_ns.error();
  SimulatorOptions options;
  options.random_seed = static_cast<uint64_t>(FLAGS_seed);
  options.exposure_s = 1e-3 * FLAGS_exposure_ms;
  options.renderer.noise_grey = FLAGS_noise;
  const auto simulator = Simulator::Make(config.set_up, *path, options);
  if (!simulator) return simulator.error();
  std::vector<SimulatedFrame> frames;
  Progress progress("rendering", stamps_ns->size());
  const auto rendered = ForEachInOrder(
      stamps_ns->size(), ResolveThreads(FLAGS_threads),
      [&](size_t i) { return simulator->MakeFrame(i, (*stamps_ns)[i]); },
      [&](size_t i, SimulatedFrame frame) -> Status {
        frames.push_back(std::move(frame));
        progress.Update(i + 1);
        return Ok();
      });
  if (!rendered) return rendered.error();
  return frames;
}

void PrintMethod(const char* name, const MethodRun& run, double reference_ms) {
  const double p50 = Quantile(run.frame_ms, 0.5), p99 = Quantile(run.frame_ms, 0.99);
  std::printf("%-34s %6.1f %8.2f %8.2f %8.2f %8.2f", name,
              static_cast<double>(run.tags) / static_cast<double>(run.frame_ms.size()), p50, p99,
              p50 / reference_ms, p99 / reference_ms);
  if (run.posed > 0) {
    std::printf(" %10.3f", 1e3 * std::sqrt(run.squared_position_m2 / run.posed));
    if (run.squared_velocity_mps2 > 0) {
      std::printf(" %10.2f", 1e3 * std::sqrt(run.squared_velocity_mps2 / run.posed));
    }
  }
  std::printf("\n");
}

double Mean(const MethodRun& run) {
  return std::accumulate(run.frame_ms.begin(), run.frame_ms.end(), 0.0) /
         static_cast<double>(run.frame_ms.size());
}

// Frame by frame every method in turn, so that what slows the machine slows all of them.
Status Measure() {
  const Config config = ScaledConfig(FLAGS_scale);
  const auto frames = RenderFlight(config);
  if (!frames) return frames.error();
  auto plain = PlainMethod::Create(config, /*with_pose=*/false);
  auto posed = PlainMethod::Create(config, /*with_pose=*/true);
  auto guided = OnlineMethod::Create(config, /*guided=*/true);
  auto full = OnlineMethod::Create(config, /*guided=*/false);
  auto pieces = PiecesMethod::Create(config);
  if (!pieces) return pieces.error();
  for (const auto* method : {&plain, &posed}) {
    if (!*method) return method->error();
  }
  for (const auto* method : {&guided, &full}) {
    if (!*method) return method->error();
  }
  Progress progress("measuring", frames->size());
  for (size_t i = 0; i < frames->size(); ++i) {
    const SimulatedFrame& frame = (*frames)[i];
    plain->Add(frame);
    posed->Add(frame);
    pieces->Add(frame);
    if (const auto added = guided->Add(frame); !added) return added;
    if (const auto added = full->Add(frame); !added) return added;
    progress.Update(i + 1);
  }
  pieces->Finish();
  const double reference_ms = Quantile(plain->run().frame_ms, 0.5);
  std::printf("%zu frames of %d x %d px, CPU time of one thread; RMSE against the exact truth\n",
              frames->size(), config.set_up.rig.front().camera.width,
              config.set_up.rig.front().camera.height);
  std::printf("%-34s %6s %8s %8s %8s %8s %10s %10s\n", "", "tags", "p50 ms", "p99 ms", "p50/ref",
              "p99/ref", "pos. mm", "vel. mm/s");
  PrintMethod("AprilTag, plain (ref)", plain->run(), reference_ms);
  PrintMethod("AprilTag, plain, + solvePnP", posed->run(), reference_ms);
  PrintMethod("tagtwist online, guided", guided->run(), reference_ms);
  PrintMethod("tagtwist online, every image searched", full->run(), reference_ms);
  PrintMethod("tagtwist batch, but for the solve", pieces->run(), reference_ms);
  std::printf("  guided: mean of all frames, the first included, %.2f ms\n", Mean(guided->run()));
  std::printf("  batch: mean of all frames %.2f ms, of the reference's mean %.3f\n",
              Mean(pieces->run()), Mean(pieces->run()) / Mean(plain->run()));
  for (const auto& [name, stage_ms] : guided->stages()) {
    std::printf("  guided: %-10s p50 %.2f, p99 %.2f ms\n", name.c_str(), Quantile(stage_ms, 0.5),
                Quantile(stage_ms, 0.99));
  }
  return Ok();
}

Usage EndToEndUsage() {
  return {"end_to_end",
          "[--trajectory NAME] [--scale X] [...]",
          "What a frame takes online, from image to state: tagtwist beside plain AprilTag\n"
          "detection (quad_decimate 1, nothing else), and with solvePnP, on the same rendered\n"
          "images in one run and one thread.",
          {{"The flight", {"trajectory", "duration", "height", "rate", "seed"}},
           {"The camera", {"scale", "exposure_ms", "noise"}},
           {"Running", {"threads"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem(
      {CheckRange("duration", FLAGS_duration, 1, 1e4), CheckRange("height", FLAGS_height, 0.1, 100),
       CheckRange("rate", FLAGS_rate, 1, 1000), CheckRange("scale", FLAGS_scale, 0.25, 8),
       CheckRange("exposure_ms", FLAGS_exposure_ms, 0, 1000),
       CheckRange("noise", FLAGS_noise, 0, 255), CheckRange("seed", FLAGS_seed, 0, 1e9),
       CheckRange("threads", FLAGS_threads, 0, 256)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  cv::setNumThreads(1);
  return tagtwist::internal::RunBench(argc, argv, tagtwist::internal::EndToEndUsage(),
                                      tagtwist::internal::FlagProblem, tagtwist::internal::Measure);
}
