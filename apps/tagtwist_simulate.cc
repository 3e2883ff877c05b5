
#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "apps/simulate/simulate_flags.h"
#include "apps/support/clean_end.h"
#include "apps/support/guarded_main.h"
#include "estimator/online/config.h"
#include "frontend/base/files/run_files.h"
#include "frontend/base/printable.h"

namespace tagtwist::internal {
namespace {

Status CheckInputsAreKept(const SimulateJob& job) {
  RunFiles files;
  files.Reads("--config", job.config.config);
  files.Reads("--camera_file", job.config.camera_file);
  files.Reads("--map", job.config.map.path);
  files.Reads("--trajectory", job.trajectory);
  files.Reads("--image_times", job.image_times);
  if (auto checked = files.Writes("--output", job.output); !checked) return checked;
  return files.WritesStandardOutput();
}

Status SimulateCamera(const SimulateJob& job, const SimulatedCamera& camera,
                      const SplineTrajectory& trajectory) {
  const auto simulator = Simulator::Make(camera.set_up, trajectory, camera.options);
  if (!simulator) return simulator.error();
  const std::vector<int64_t>& times_ns = camera.times_ns;
  const bool sees_tags = std::any_of(times_ns.begin(), times_ns.end(), [&](int64_t t_ns) {
    return !simulator->FindVisibleTags(t_ns).empty();
  });
  if (!sees_tags) {
    std::cerr << "tagtwist_simulate: no frame sees a tag: does the camera look at the map?\n";
  }
  const auto writer = CreateDatasetWriter(camera.output, *ParseFormat(job.format));
  if (!writer) return writer.error();
  const auto written =
      WriteFlight(job, *simulator, times_ns, camera.clock_offset_ns, writer->get());
  if (!written) return written;
  std::cout << camera.output << ": " << times_ns.size() << " frames, "
            << ToSeconds(times_ns.back() - times_ns.front()) << " s\n";
  return Ok();
}

Status Simulate(const SimulateJob& job) {
  if (const auto kept = CheckInputsAreKept(job); !kept) return kept;
  const auto config = LoadConfig(job.config);
  if (!config) return config.error();
  const auto trajectory = PrepareTrajectory(job, config->set_up.map);
  if (!trajectory) return trajectory.error();
  std::string warning;
  const auto stamps_ns = PrepareStamps(job, *trajectory, &warning);
  if (!stamps_ns) return stamps_ns.error();
  if (!warning.empty()) std::cerr << "tagtwist_simulate: " << Printable(warning) << "\n";
  if (config->recordings.empty()) {
    const SimulatedCamera only{config->set_up, job.simulator, job.output, *stamps_ns, 0};
    return SimulateCamera(job, only, *trajectory);
  }
  if (!job.image_times.empty()) {
    return Error{job.config.config + ": cameras: --image_times is of one camera"};
  }
  const auto cameras = CamerasOf(job, *config, *stamps_ns);
  if (!cameras) return cameras.error();
  for (const SimulatedCamera& camera : *cameras) {
    const auto folder = std::filesystem::path(camera.output).parent_path();
    std::error_code failure;
    std::filesystem::create_directories(folder, failure);
    if (failure) {
      return Error{folder.string() + ": cannot make this folder: " + failure.message()};
    }
    if (auto done = SimulateCamera(job, camera, *trajectory); !done) return done;
  }
  return Ok();
}

int Main(int argc, char** argv, const Usage& usage) {
  ParseFlagsOrExit2(argc, argv, usage);
  const auto job = SimulateJobFromFlags();
  if (!job) return Fail(usage, job.error().message, 2);
  const CleanEnd end(usage, {{job->output}, ""});
  const auto done = Simulate(*job);
  return done ? 0 : Fail(usage, done.error().message);
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::GuardedMain(argc, argv, tagtwist::internal::SimulateUsage,
                                         tagtwist::internal::Main);
}
