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

Status WriteFlight(const SimulateJob& job, const Simulator& simulator,
                   const std::vector<int64_t>& stamps_ns, DatasetWriter* writer) {
  Progress progress("frames", stamps_ns.size());
  std::vector<TruthSample> truth;
  auto written = ForEachInOrder(
      stamps_ns.size(), ResolveThreads(job.threads),
      [&](size_t i) { return simulator.MakeFrame(i, stamps_ns[i]); },
      [&](size_t i, const SimulatedFrame& frame) {
        truth.push_back({frame.t_ns, frame.truth.world_from_body, frame.truth.twist});
        progress.Update(i + 1);
        return writer->Add({frame.t_ns, frame.image, frame.detections});
      });
  if (!written) return written;
  return writer->Finish(truth, simulator.MakeImu(stamps_ns.front(), stamps_ns.back()));
}

Result<DatasetFormat> ParseFormat(const std::string& name) {
  if (name == "folder") return DatasetFormat::kFolder;
  if (name == "euroc") return DatasetFormat::kEuroc;
  if (name == "mat") return DatasetFormat::kMat;
  return Error{"--format: expected folder, euroc or mat, got '" + name + "'"};
}

}  // namespace tagtwist::internal
