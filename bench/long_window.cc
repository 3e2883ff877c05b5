#include <gflags/gflags.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <optional>
#include <vector>

#include "bench/cpu_clock.h"
#include "bench/endless_flight.h"
#include "bench/run_bench.h"
#include "estimator/jobs/progress.h"
#include "estimator/window/sliding_window.h"
#include "frontend/base/option_check.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/front_end.h"
#include "frontend/tags/find_tags.h"

DEFINE_int32(frames, 1000000, "How many.");
DEFINE_string(trajectory, "figure8", "Flown forth and back: as tagtwist_simulate's.");
DEFINE_double(rate, 49, "Frames a second.");
DEFINE_double(corner_noise_px, 0.3, "Noise of the corners, standard deviation [px].");
DEFINE_int32(seed, 1, "Of everything random.");

namespace tagtwist::internal {
namespace {

constexpr int kSettledFrames = 1000;  // the memory is compared with that after so many

// Resident memory of this process [MiB].
double ResidentMiB() {
  std::ifstream file("/proc/self/statm");
  double size = 0, resident = 0;
  file >> size >> resident;
  return resident * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1 << 20);
}

// Times and errors of a stretch of the run.
struct Stretch {
  std::vector<float> window_ms;
  double squared_position_m2 = 0, squared_velocity_mps2 = 0;
  size_t judged = 0;

  void Add(float ms, const FrameEstimate& estimate, const BodyState& truth) {
    window_ms.push_back(ms);
    if (estimate.status == FrameStatus::kNoFix) return;
    const StateVector e = Difference(estimate.state, truth);
    squared_position_m2 += e.segment<3>(3).squaredNorm();
    squared_velocity_mps2 += e.segment<3>(6).squaredNorm();
    ++judged;
  }
};

void Print(const char* name, const Stretch& s, double resident_mib) {
  const std::vector<double> ms(s.window_ms.begin(), s.window_ms.end());
  const auto n = static_cast<double>(s.judged);
  std::printf(
      "%-12s %9zu frames: window p50 %.3f, p99 %.3f ms; RMSE %.3f mm, %.2f mm/s; %.1f MiB\n", name,
      s.window_ms.size(), Quantile(ms, 0.5), Quantile(ms, 0.99),
      1e3 * std::sqrt(s.squared_position_m2 / n), 1e3 * std::sqrt(s.squared_velocity_mps2 / n),
      resident_mib);
}

Status Measure() {
  const Config config = DefaultConfig();
  const auto flight = EndlessFlight::Make(config, FLAGS_trajectory, FLAGS_rate,
                                          FLAGS_corner_noise_px, static_cast<uint64_t>(FLAGS_seed));
  if (!flight) return flight.error();
  SlidingWindow window(config.set_up, config.estimator);
  // A tenth of the frames each; what this program itself keeps is there from the start.
  const int tenth = FLAGS_frames / 10;
  Stretch first, last;
  for (Stretch* stretch : {&first, &last}) {
    stretch->window_ms.assign(static_cast<size_t>(tenth), 0);
    stretch->window_ms.clear();
  }
  Progress progress("estimating", static_cast<size_t>(FLAGS_frames));
  double settled_mib = 0, first_mib = 0;
  for (int i = 0; i < FLAGS_frames; ++i) {
    const SimulatedFrame frame = flight->At(i);
    FrameMeasurements measurement;
    measurement.t_ns = frame.t_ns;
    measurement.tags =
        FilterTags(frame.detections, config.set_up.map, config.set_up.rig.front().camera,
                   config.front_end.detector.border_px);
    const CpuClock clock;
    const auto output = window.Add(measurement);
    const auto ms = static_cast<float>(clock.ElapsedMs());
    if (!output) return output.error();
    if (i < tenth) first.Add(ms, output->current, frame.truth);
    if (i >= FLAGS_frames - tenth) last.Add(ms, output->current, frame.truth);
    if (i + 1 == kSettledFrames) settled_mib = ResidentMiB();
    if (i + 1 == tenth) first_mib = ResidentMiB();
    progress.Update(static_cast<size_t>(i + 1));
  }
  const double last_mib = ResidentMiB();  // before what printing takes
  std::printf("resident after %d frames: %.1f MiB\n", kSettledFrames, settled_mib);
  Print("first tenth", first, first_mib);
  Print("last tenth", last, last_mib);
  for (const std::string& warning : window.Warnings()) std::printf("%s\n", warning.c_str());
  return Ok();
}

Usage LongWindowUsage() {
  return {"long_window",
          "[--frames N] [...]",
          "Whether the window stays as fast and as small as it was: memory and time of a frame,\n"
          "at the start and at the end of a long flight. CPU time of the thread.",
          {{"The flight", {"frames", "trajectory", "rate", "corner_noise_px", "seed"}}}};
}

std::optional<std::string> FlagProblem() {
  return FirstFlagProblem({CheckRange("frames", FLAGS_frames, kSettledFrames, 1e9),
                           CheckRange("rate", FLAGS_rate, 1, 1000),
                           CheckRange("corner_noise_px", FLAGS_corner_noise_px, 0, 10),
                           CheckRange("seed", FLAGS_seed, 0, 1e9)});
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::RunBench(argc, argv, tagtwist::internal::LongWindowUsage(),
                                      tagtwist::internal::FlagProblem, tagtwist::internal::Measure);
}
