#include "estimator/jobs/map_recording.h"

#include <algorithm>
#include <utility>

#include "estimator/jobs/calibrate_recording.h"
#include "frontend/base/number_text.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/types/tag_family.h"

namespace tagtwist::internal {
namespace {

// The known tags, and every other one of the family somewhere, so that none is passed over but the
// movable ones.
Result<TagMap> AllTags(const MappingOptions& options, const std::vector<int>& movable) {
  const auto size = TagFamilySize(options.family);
  if (!size) return size.error();
  const TagMap known(options.family, options.known);
  std::vector<Tag> tags = options.known;
  for (int id = 0; id < *size; ++id) {
    if (known.Find(id) != nullptr || std::count(movable.begin(), movable.end(), id) > 0) continue;
    const Eigen::Vector3d place(2 * id * options.tag_size_m, 0, 0);
    tags.push_back({id, MakePose(Eigen::Quaterniond::Identity(), place), options.tag_size_m});
  }
  return TagMap(options.family, std::move(tags));
}

}  // namespace

Result<Mapping> MapRecording(const MapJob& job, const Config& config) {
  if (!config.recordings.empty() || !config.set_up.rig.IsOneOnTheBody()) {
    return Error{job.recording +
                 ": a map is made with one camera on the body, and the configuration has "
                 "others: name one by camera and cam_from_body instead"};
  }
  Config any = config;
  auto all = AllTags(job.mapping, config.movable_tags);
  if (!all) return all.error();
  any.set_up.map = std::move(*all);
  auto source = OpenDataSource(
      job.recording, {job.use_detections, !job.use_detections, {}, job.topic, {}, config.limits});
  if (!source) return source.error();
  RunOptions options;
  options.use_detections = job.use_detections;
  options.threads = job.threads;
  const auto measurements = MeasureRecording("mapping", source->get(), any, options);
  if (!measurements) return measurements.error();
  auto mapping = MapTags(config.set_up.rig.front().camera, *measurements, job.mapping);
  if (!mapping) return Error{job.recording + ": " + mapping.error().message};
  return mapping;
}

Result<Mapping> MapUnknownTags(MapJob job, const Config& config) {
  job.mapping.known = config.set_up.map.tags();
  job.mapping.family = config.set_up.map.family();
  const double size_m = job.mapping.known.front().size_m;
  for (const Tag& tag : job.mapping.known) {
    if (job.mapping.tag_size_m > 0 || tag.size_m == size_m) continue;
    return Error{"--unknown_tag_size_m: needed with --map_unknown_tags, for the map has tags of " +
                 FormatNumber(size_m) + " and " + FormatNumber(tag.size_m) + " m"};
  }
  if (!(job.mapping.tag_size_m > 0)) job.mapping.tag_size_m = size_m;
  return MapRecording(job, config);
}

}  // namespace tagtwist::internal
