#include "apps/map_recording.h"

#include <cmath>
#include <utility>

#include "apps/calibrate_recording.h"
#include "estimator/format_text.h"
#include "estimator/tag_map_text.h"
#include "frontend/data_source.h"
#include "frontend/tag_family.h"

namespace tagtwist {
namespace {

// Every tag of the family, somewhere: so that none is passed over.
Result<TagMap> AllTags(const MappingOptions& options) {
  const auto size = TagFamilySize(options.family);
  if (!size) return size.error();
  std::vector<Tag> tags;
  for (int id = 0; id < *size; ++id) {
    const Eigen::Vector3d place(2 * id * options.tag_size_m, 0, 0);
    tags.push_back({id, MakePose(Eigen::Quaterniond::Identity(), place), options.tag_size_m});
  }
  return TagMap(options.family, std::move(tags));
}

}  // namespace

Result<Mapping> MapRecording(const MapJob& job, const Config& config) {
  Config any = config;
  auto all = AllTags(job.mapping);
  if (!all) return all.error();
  any.map = std::move(*all);
  auto source = OpenDataSource(job.recording, {job.use_detections, !job.use_detections, {}});
  if (!source) return source.error();
  RunOptions options;
  options.use_detections = job.use_detections;
  options.threads = job.threads;
  const auto measurements = MeasureRecording("mapping", source->get(), any, options);
  if (!measurements) return measurements.error();
  auto mapping = MapTags(config.camera, *measurements, job.mapping);
  if (!mapping) return Error{job.recording + ": " + mapping.error().message};
  return mapping;
}

std::string MappingText(const Mapping& mapping) {
  std::vector<std::string> notes;
  for (const auto& covariance : mapping.covariances) {
    const double position_m = std::sqrt(covariance.bottomRightCorner<3, 3>().trace());
    const double rotation_rad = std::sqrt(covariance.topLeftCorner<3, 3>().trace());
    notes.push_back(
        position_m > 0 ? Format("+- %.1f mm, %.2f deg", 1e3 * position_m, rotation_rad * 180 / M_PI)
                       : "fixes the world");
  }
  std::string out = Format("# %zu tags mapped, corner noise %.3f px\n", mapping.map.tags().size(),
                           mapping.corner_sigma_px);
  for (const int id : mapping.left_out) {
    out += Format("# tag %d was seen, and could not be placed\n", id);
  }
  return out + FormatTagMap(mapping.map, notes);
}

}  // namespace tagtwist
