#include "estimator/online/recording_options.h"

#include <cmath>
#include <filesystem>

#include "frontend/io/recordings/camera_info.h"
#include "frontend/io/recordings/rig/rig_source.h"

namespace tagtwist::internal {
namespace {

// Where a camera's recording is: of a bag, in it.
std::string PlaceOf(const std::string& dataset, const std::string& recording) {
  namespace fs = std::filesystem;
  std::error_code unknown;
  const fs::path root(dataset);
  if (IsRosBag(dataset)) return dataset;
  const fs::path in_mav = root / "mav0" / recording;
  const bool is_in_mav = !fs::exists(root / recording, unknown) && fs::exists(in_mav, unknown);
  return (is_in_mav ? in_mav : root / recording).string();
}

// What two cameras have seen alike would count twice.
Status CheckApart(const std::vector<RigRecording>& recordings, const Rig& rig) {
  for (size_t i = 0; i < recordings.size(); ++i) {
    for (size_t j = 0; j < i; ++j) {
      const RigRecording &a = recordings[j], &b = recordings[i];
      const bool alike = a.topic == b.topic || a.topic.empty() || b.topic.empty();
      if (a.path != b.path || !alike) continue;
      return Error{a.path +
                   ": expected a recording, or a topic of a bag, for each camera, got one "
                   "for " +
                   rig.cameras[j].name + " and " + rig.cameras[i].name};
    }
  }
  return Ok();
}

}  // namespace

Result<std::unique_ptr<DataSource>> OpenRecording(const std::string& dataset, const Config& config,
                                                  const DataSourceOptions& options) {
  if (config.recordings.empty()) return OpenDataSource(dataset, options);
  std::vector<RigRecording> recordings;
  for (size_t i = 0; i < config.recordings.size(); ++i) {
    const CameraRecording& one = config.recordings[i];
    recordings.push_back({PlaceOf(dataset, one.path), one.topic,
                          std::llround(1e9 * config.set_up.rig.cameras.at(i).clock_offset_s)});
  }
  if (const Status apart = CheckApart(recordings, config.set_up.rig); !apart) return apart.error();
  return OpenRigSource(recordings, options);
}

}  // namespace tagtwist::internal
