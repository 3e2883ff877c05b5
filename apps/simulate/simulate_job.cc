#include "apps/simulate/simulate_job.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iterator>

#include "estimator/jobs/in_order.h"
#include "estimator/jobs/progress.h"
#include "frontend/base/option_check.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "frontend/simulation/named_flights.h"

namespace tagtwist::internal {
namespace {

constexpr double kNamedFlightS = 20;

bool IsFlightName(const std::string& name) {
  const std::vector<std::string> names = FlightNames();
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

std::optional<std::string> SimulateJob::Problem() const {
  FlightOptions flight;
  flight.duration_s = duration_s != 0 ? duration_s : kNamedFlightS;
  flight.height_m = height_m;
  for (const auto& problem :
       {flight.Problem(), StampOptions{rate_hz, jitter_s, simulator.random_seed}.Problem(),
        simulator.Problem(), CheckRange("threads", threads, 0, 256)}) {
    if (problem) return problem;
  }
  return std::nullopt;
}

Result<std::vector<int64_t>> ReadImageTimes(const std::string& path, const Limits& limits) {
  const auto table = CsvTable::Read(path, limits);
  if (!table) return table.error();
  const auto column = table->RequireColumns({"t"});
  if (!column) return column.error();
  std::vector<int64_t> out;
  for (size_t row = 0; row < table->rows(); ++row) {
    const auto t_ns = table->Seconds(row, column->front());
    if (!t_ns) return t_ns.error();
    if (!out.empty() && *t_ns <= out.back()) {
      return table->ErrorAt(row, "t: expected stamps that grow");
    }
    out.push_back(*t_ns);
  }
  if (out.empty()) return Error{path + ": expected at least one stamp"};
  return out;
}

Result<SplineTrajectory> PrepareTrajectory(const SimulateJob& job, const TagMap& map) {
  if (IsFlightName(job.trajectory)) {
    FlightOptions options;
    options.duration_s = job.duration_s > 0 ? job.duration_s : kNamedFlightS;
    options.height_m = job.height_m;
    return FlightPath(job.trajectory, map, options);
  }
  if (!std::filesystem::exists(job.trajectory)) {
    std::string known;
    for (const std::string& name : FlightNames()) known += ", " + name;
    return Error{job.trajectory + ": no such file, and no flight of that name (" + known.substr(2) +
                 ")"};
  }
  const auto poses = ReadGroundTruth(job.trajectory, job.config.limits);
  if (!poses) return poses.error();
  auto trajectory = SplineTrajectory::Fit(*poses, {});
  if (!trajectory) return Error{job.trajectory + ": " + trajectory.error().message};
  return trajectory;
}

Result<std::vector<int64_t>> PrepareStamps(const SimulateJob& job,
                                           const SplineTrajectory& trajectory,
                                           std::string* warning) {
  const int64_t first_ns = trajectory.first_ns();
  int64_t last_ns = trajectory.last_ns();
  if (job.duration_s > 0) {
    last_ns = std::min<int64_t>(last_ns, first_ns + std::llround(1e9 * job.duration_s));
  }
  if (job.image_times.empty()) {
    return MakeStamps(first_ns, last_ns, {job.rate_hz, job.jitter_s, job.simulator.random_seed});
  }
  const auto stamps = ReadImageTimes(job.image_times, job.config.limits);
  if (!stamps) return stamps.error();
  std::vector<int64_t> out;
  std::copy_if(stamps->begin(), stamps->end(), std::back_inserter(out),
               [&](int64_t t_ns) { return t_ns >= first_ns && t_ns <= last_ns; });
  if (out.empty()) return Error{job.image_times + ": no stamp lies within the trajectory"};
  if (out.size() < stamps->size()) {
    *warning = job.image_times + ": " + std::to_string(stamps->size() - out.size()) + " of " +
               std::to_string(stamps->size()) + " stamps lie outside the flight and are left out";
  }
  return out;
}

Result<std::vector<SimulatedCamera>> CamerasOf(const SimulateJob& job, const Config& config,
                                               const std::vector<int64_t>& stamps_ns) {
  constexpr uint64_t kNextSeed = 1'000'003;
  constexpr double kGolden = 0.6180339887498949;  // phases that keep apart, however many
  std::vector<SimulatedCamera> out;
  std::vector<double> clocks_s;  // one after the other as they come
  for (size_t i = 0; i < config.recordings.size(); ++i) {
    const RigCamera& mounted = config.set_up.rig.cameras.at(i);
    const Rig alone{{mounted}, config.set_up.rig.mounted_on};
    SimulatedCamera camera{{alone, config.set_up.map}, job.simulator, "", stamps_ns, 0};
    camera.output = (std::filesystem::path(job.output) / config.recordings[i].path).string();
    camera.options.random_seed += kNextSeed * i;
    if (mounted.line_time_s != 0) camera.options.line_time_s = mounted.line_time_s;
    camera.clock_offset_ns = std::llround(1e9 * mounted.clock_offset_s);
    auto clock = std::find(clocks_s.begin(), clocks_s.end(), mounted.clock_offset_s);
    if (clock == clocks_s.end()) clock = clocks_s.insert(clock, mounted.clock_offset_s);
    if (const auto order = clock - clocks_s.begin(); order > 0) {
      const double phase = std::fmod(kGolden * static_cast<double>(order), 1.0);
      const auto times_ns = MakeStamps(
          stamps_ns.front() + std::llround(1e9 * phase / job.rate_hz), stamps_ns.back(),
          {job.rate_hz, job.jitter_s, job.simulator.random_seed + static_cast<uint64_t>(order)});
      if (!times_ns) return times_ns.error();
      camera.times_ns = *times_ns;
    }
    if (camera.times_ns.empty()) {
      return Error{camera.output + ": the flight is too short for a frame of this camera's clock"};
    }
    out.push_back(std::move(camera));
  }
  return out;
}

Status WriteFlight(const SimulateJob& job, const Simulator& simulator,
                   const std::vector<int64_t>& times_ns, int64_t clock_offset_ns,
                   DatasetWriter* writer) {
  Progress progress("frames", times_ns.size());
  std::vector<TruthSample> truth;
  auto written = ForEachInOrder(
      times_ns.size(), ResolveThreads(job.threads),
      [&](size_t i) { return simulator.MakeFrame(i, times_ns[i]); },
      [&](size_t i, const SimulatedFrame& frame) {
        const int64_t stamp_ns = frame.t_ns - clock_offset_ns;
        truth.push_back({stamp_ns, frame.truth.world_from_body, frame.truth.twist});
        progress.Update(i + 1);
        return writer->Add({stamp_ns, frame.image, frame.detections});
      });
  if (!written) return written;
  auto imu = simulator.MakeImu(times_ns.front(), times_ns.back());
  for (ImuSample& sample : imu) sample.t_ns -= clock_offset_ns;
  return writer->Finish(truth, imu);
}

Result<DatasetFormat> ParseFormat(const std::string& name) {
  if (name == "folder") return DatasetFormat::kFolder;
  if (name == "euroc") return DatasetFormat::kEuroc;
  if (name == "mat") return DatasetFormat::kMat;
  return Error{"--format: expected folder, euroc or mat, got '" + name + "'"};
}

}  // namespace tagtwist::internal
