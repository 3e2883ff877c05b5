
#include <algorithm>
#include <iostream>
#include <memory>

#include "apps/simulate/simulate_flags.h"
#include "apps/support/clean_end.h"
#include "apps/support/guarded_main.h"
#include "estimator/online/config.h"
#include "frontend/base/files/run_files.h"

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

Status Simulate(const SimulateJob& job) {
  if (const auto kept = CheckInputsAreKept(job); !kept) return kept;
  const auto config = LoadConfig(job.config);
  if (!config) return config.error();
  const auto trajectory = PrepareTrajectory(job, config->set_up.map);
  if (!trajectory) return trajectory.error();
  std::string warning;
  const auto stamps_ns = PrepareStamps(job, *trajectory, &warning);
  if (!stamps_ns) return stamps_ns.error();
  if (!warning.empty()) std::cerr << "tagtwist_simulate: " << warning << "\n";
  const auto simulator = Simulator::Make(config->set_up, *trajectory, job.simulator);
  if (!simulator) return simulator.error();
  const bool sees_tags = std::any_of(stamps_ns->begin(), stamps_ns->end(), [&](int64_t t_ns) {
    return !simulator->FindVisibleTags(t_ns).empty();
  });
  if (!sees_tags) {
    std::cerr << "tagtwist_simulate: no frame sees a tag: does cam_from_body look at the map?\n";
  }

  const auto writer = CreateDatasetWriter(job.output, *ParseFormat(job.format));
  if (!writer) return writer.error();
  if (auto written = WriteFlight(job, *simulator, *stamps_ns, writer->get()); !written) {
    return written;
  }
  std::cout << job.output << ": " << stamps_ns->size() << " frames, "
            << ToSeconds(stamps_ns->back() - stamps_ns->front()) << " s\n";
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
