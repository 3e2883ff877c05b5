#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/online/config.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/dataset_writer.h"
#include "frontend/simulation/simulator.h"

namespace tagtwist::internal {

/// What tagtwist_simulate was asked to do.
struct SimulateJob {
  std::string output, trajectory = "figure8", image_times, format = "folder";
  ConfigFiles config;
  double duration_s = 0;                  // 0: 20 s of a named flight, all of a file
  double height_m = 1.2;                  // of a named flight
  double rate_hz = 49, jitter_s = 0.002;  // of the frames, without image_times
  int threads = 0;                        // 0: as many as the machine has
  SimulatorOptions simulator;
  std::optional<std::string> Problem() const;  // of the numbers
};

/// Stamps of a CSV file with a column t [s], strictly growing.
Result<std::vector<int64_t>> ReadImageTimes(const std::string& path);

/// The spline through a named flight over the map or through the poses of a file.
Result<SplineTrajectory> PrepareTrajectory(const SimulateJob& job, const TagMap& map);

/// The frames' stamps within the trajectory; image times outside of it are left out, with a
/// warning.
Result<std::vector<int64_t>> PrepareStamps(const SimulateJob& job,
                                           const SplineTrajectory& trajectory,
                                           std::string* warning);

/// One camera of a rig as it takes and stamps its frames.
struct SimulatedCamera {
  SetUp set_up;  // of it alone
  SimulatorOptions options;
  std::string output;
  std::vector<int64_t> times_ns;  // of its frames, by the body's clock,
  int64_t clock_offset_ns = 0;    // which is what its own shows plus this
};
/// The rig's cameras, where the configuration has `cameras`: each with noise of its own, and its
/// recording in the output folder. Those whose clock shows the same as the first's take their
/// frames with it; those of another clock run freely, each clock at a phase of its own. An error: a
/// flight that is too short for one.
Result<std::vector<SimulatedCamera>> CamerasOf(const SimulateJob& job, const Config& config,
                                               const std::vector<int64_t>& stamps_ns);

/// Renders every frame and writes the data set, all stamps by the camera's clock: what the body's
/// shows less `clock_offset_ns`. Progress goes to standard error where that is a terminal.
Status WriteFlight(const SimulateJob& job, const Simulator& simulator,
                   const std::vector<int64_t>& times_ns, int64_t clock_offset_ns,
                   DatasetWriter* writer);

/// "folder", "euroc" or "mat".
Result<DatasetFormat> ParseFormat(const std::string& name);

}  // namespace tagtwist::internal
