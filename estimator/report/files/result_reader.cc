#include "estimator/report/files/result_reader.h"

#include <filesystem>

#include "estimator/report/files/states_csv.h"
#include "frontend/base/files/file_set.h"
#include "frontend/base/files/input_file.h"
#include "frontend/io/trajectories/trajectory_file.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;

bool Exists(const fs::path& path) {
  std::error_code ignored;
  return fs::is_regular_file(path, ignored);
}

bool IsStatesCsv(const std::string& path) {
  std::string header = FirstBytes(path, 400);  // the columns looked for are among the first
  header = header.substr(0, header.find('\n'));
  return header.find("cf_x") != std::string::npos || header.find("sigma_") != std::string::npos;
}

Result<PoseSeries> ReadPoses(const std::string& path, const Limits& limits) {
  const auto samples = ReadGroundTruth(path, limits);
  if (!samples) return samples.error();
  PoseSeries out;
  for (const TruthSample& s : *samples) {
    out.push_back({s.t_ns, s.world_from_body, s.twist, std::nullopt});
  }
  return out;
}

// states.csv and the covariance file that belongs to it: "states_x.csv", "covariance_x.csv".
Result<StatesFile> ReadStates(const fs::path& path, const Limits& limits) {
  auto states = ReadStatesCsv(path.string(), limits);
  if (!states) return states;
  std::string name = path.filename().string();
  if (name.rfind("states", 0) != 0) return states;
  const fs::path covariance = path.parent_path() / name.replace(0, 6, "covariance");
  if (!Exists(covariance)) return states;
  if (auto read = ReadCovarianceCsv(covariance.string(), &states->states, limits); !read) {
    return read.error();
  }
  return states;
}

Status ReadTruthBeside(const fs::path& folder, const Limits& limits, ReadResults* out) {
  for (const char* name : {"ground_truth_states.csv", "ground_truth.tum"}) {
    const fs::path path = folder / name;
    if (!Exists(path)) continue;
    auto truth = ReadGroundTruth(path.string(), limits);
    if (!truth) return truth.error();
    out->truth = std::move(*truth);
    out->truth_path = path.string();
    return Ok();
  }
  return Ok();
}

Status ReadFolder(const fs::path& folder, const std::string& name, const Limits& limits,
                  ReadResults* out) {
  auto states = ReadStates(folder / "states.csv", limits);
  if (!states) return states.error();
  if (states->closed_form.empty() && Exists(folder / "closed_form.tum")) {
    // A run whose every frame lacks a closed form leaves a file with no pose, which is no error.
    if (auto poses = ReadPoses((folder / "closed_form.tum").string(), limits)) {
      states->closed_form = std::move(*poses);
    }
  }
  const bool window = Exists(folder / "states_lagged.csv");
  if (!states->closed_form.empty()) {
    out->series.push_back({name + ": closed form", std::move(states->closed_form)});
  }
  out->series.push_back(
      {name + (window ? ": optimised, lag 0" : ": optimised"), std::move(states->states)});
  if (!window) return Ok();
  auto lagged = ReadStates(folder / "states_lagged.csv", limits);
  if (!lagged) return lagged.error();
  out->series.push_back({name + ": optimised, lagged", std::move(lagged->states)});
  return Ok();
}

}  // namespace

std::vector<std::string> FilesReadAt(const std::string& path) {
  std::error_code ignored;
  const bool is_folder = fs::is_directory(path, ignored);
  std::vector<std::string> out;
  if (!is_folder) out.push_back(path);
  const fs::path folder = is_folder ? fs::path(path) : fs::path(path).parent_path();
  for (const char* name : {"ground_truth_states.csv", "ground_truth.tum"}) {
    out.push_back((folder / name).string());
  }
  std::string file = fs::path(path).filename().string();
  if (!is_folder && file.rfind("states", 0) == 0) {
    out.push_back((folder / file.replace(0, 6, "covariance")).string());
  }
  if (!is_folder) return out;
  for (const char* name : {"states.csv", "states_lagged.csv", "closed_form.tum", "covariance.csv",
                           "covariance_lagged.csv"}) {
    out.push_back((folder / name).string());
  }
  return out;
}

Result<ReadResults> ReadResultsAt(const std::string& path, const Limits& limits) {
  ReadResults out;
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    fs::path folder = fs::path(path).lexically_normal();
    if (!folder.has_filename()) folder = folder.parent_path();
    if (!IsFileSetWhole(folder.string())) {
      return Error{
          path +
          ": a run was ended while it replaced these results, or is about to; the next run "
          "that writes there completes them"};
    }
    if (auto read = ReadFolder(folder, folder.string(), limits, &out); !read) return read.error();
    if (auto read = ReadTruthBeside(folder, limits, &out); !read) return read.error();
    return out;
  }
  if (IsStatesCsv(path)) {
    auto states = ReadStates(path, limits);
    if (!states) return states.error();
    out.series.push_back({path, std::move(states->states)});
  } else {
    auto poses = ReadPoses(path, limits);
    if (!poses) return poses.error();
    out.series.push_back({path, std::move(*poses)});
  }
  if (auto read = ReadTruthBeside(fs::path(path).parent_path(), limits, &out); !read)
    return read.error();
  return out;
}

}  // namespace tagtwist::internal
