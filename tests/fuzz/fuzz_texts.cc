// Readers of texts: what they take keeps the promises of their headers.
#include <cmath>

#include "estimator/online/config.h"
#include "estimator/online/config_text.h"
#include "estimator/report/files/states_csv.h"
#include "frontend/io/setup/camera_file.h"
#include "frontend/io/setup/rig/rig_file.h"
#include "frontend/io/setup/tag_map_file.h"
#include "frontend/io/setup/yaml_tree.h"
#include "frontend/io/tables/csv.h"
#include "frontend/io/tables/detections_reader.h"
#include "frontend/io/tables/imu_csv.h"
#include "frontend/io/tables/text_grid.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "tests/fuzz/fuzz_file.h"
#include "tests/fuzz/fuzz_target.h"

namespace tagtwist::internal {
namespace {

size_t CountNodes(const YamlValue& value) {
  size_t out = 1;
  for (const YamlValue& item : value.items) out += CountNodes(item);
  for (const auto& [name, member] : value.members) out += CountNodes(member);
  return out;
}

bool IsFinite(const Pose& pose) {
  return pose.translation().allFinite() &&
         std::abs(Eigen::Quaterniond(pose.rotation()).norm() - 1) < 1e-6;
}

template <typename Samples>
void PromiseGrowing(const Samples& samples) {
  for (size_t i = 1; i < samples.size(); ++i) {
    Promise(samples[i].t_ns > samples[i - 1].t_ns, "stamps that do not grow");
  }
}

}  // namespace

bool FuzzYaml(const std::string& bytes) {
  const auto tree = ParseYaml(bytes, "x.yaml");
  if (!IsTaken(tree)) return false;
  Promise(CountNodes(*tree) <= 400'000, "more nodes than the bound");
  return true;
}

bool FuzzCamera(const std::string& bytes) {
  const FuzzFile file(bytes);
  bool taken = false;
  for (const char* name : {"", "cam1"}) {
    const auto camera = ReadCameraFile(file.path(), name);
    if (!IsTaken(camera)) continue;
    taken = true;
    Promise(!camera->camera.Problem(), "a camera with a problem");
    Promise(camera->line_time_s >= 0, "a line time below zero");
    if (camera->cam_from_body) Promise(IsFinite(*camera->cam_from_body), "a mount of no pose");
  }
  const auto rig = ReadRigFile(file.path(), {}, {});
  if (!IsTaken(rig)) return taken;
  for (const CameraOfRig& one : *rig) {
    Promise(!one.file.camera.Problem(), "a camera of a rig with a problem");
    Promise(one.file.cam_from_body && IsFinite(*one.file.cam_from_body), "no mount on the rig");
    Promise(std::isfinite(one.clock_offset_s), "a clock of no time");
  }
  return true;
}

bool FuzzMap(const std::string& bytes) {
  const FuzzFile file(bytes);
  bool taken = false;
  for (const TagMapFile& of : {TagMapFile{file.path(), 0.1, ""}, TagMapFile{file.path(), {}, ""}}) {
    const auto map = ReadTagMapFile(of);
    if (!IsTaken(map)) continue;
    taken = true;
    Promise(!map->Problem() && !CheckTagMap(*map), "a map with a problem");
    for (const Tag& tag : map->tags()) Promise(IsFinite(tag.world_from_tag), "a tag nowhere");
  }
  return taken;
}

bool FuzzConfig(const std::string& bytes) {
  const FuzzFile file(bytes);
  const auto config = LoadConfig(file.path());
  if (!IsTaken(config)) return false;
  Promise(!config->set_up.rig.front().camera.Problem(), "a camera with a problem");
  Promise(!config->set_up.map.Problem(), "a map with a problem");
  Promise(!config->estimator.Problem(), "options with a problem");
  // What is written of it is read again as the same.
  const std::string text = OptionsText(*config);
  const FuzzFile written(text);
  const auto again = LoadConfig(written.path());
  Promise(IsTaken(again), "what was written is refused");
  Promise(OptionsText(*again) == text, "what was written is read as something else");
  return true;
}

bool FuzzTable(const std::string& bytes) {
  if (auto text = DecodeText(bytes, "x.csv"); IsTaken(text)) TextGrid::Parse(std::move(*text));
  if (!IsTaken(CsvTable::Parse(bytes, "x.csv"))) return false;
  const FuzzFile file(bytes);
  bool taken = false;
  for (const TimeUnit unit : {TimeUnit::kSeconds, TimeUnit::kNanoseconds}) {
    std::vector<std::string> notes;
    const auto detections = ReadDetectionsCsv(file.path(), unit, {}, &notes);
    if (IsTaken(detections)) {
      taken = true;
      PromiseGrowing(*detections);
      for (const StampedDetections& stamped : *detections) {
        for (const TagDetection& tag : stamped.tags) {
          for (const auto& corner : tag.corners) Promise(corner.allFinite(), "a corner nowhere");
        }
      }
    }
    const auto imu = ReadImuCsv(file.path(), unit, &notes);
    if (!IsTaken(imu)) continue;
    taken = true;
    PromiseGrowing(*imu);
  }
  return taken;
}

bool FuzzTruth(const std::string& bytes) {
  const FuzzFile file(bytes);
  const auto truth = ReadTrajectoryFile(file.path(), "");
  if (!IsTaken(truth)) return false;
  Promise(!truth->samples.empty(), "a trajectory of nothing");
  PromiseGrowing(truth->samples);
  for (const TruthSample& sample : truth->samples) {
    Promise(IsFinite(sample.world_from_body), "a sample of no pose");
    const bool finite = !sample.twist ||
                        (sample.twist->v_world.allFinite() && sample.twist->omega_body.allFinite());
    Promise(finite, "a twist of no number");
  }
  return true;
}

bool FuzzStates(const std::string& bytes) {
  const FuzzFile file(bytes);
  auto states = ReadStatesCsv(file.path());
  if (IsTaken(states)) {
    PromiseGrowing(states->states);
    for (const PoseSample& sample : states->states) {
      Promise(IsFinite(sample.world_from_body), "a state of no pose");
    }
  }
  PoseSeries series = states ? states->states : PoseSeries(3);
  const bool taken = IsTaken(ReadCovarianceCsv(file.path(), &series));
  return taken || states;
}

}  // namespace tagtwist::internal
