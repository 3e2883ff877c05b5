#pragma once
#include "estimator/online/config.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// How a recording is opened that is estimated with this configuration: ids that neither the map
/// nor the list of movable tags has are errors in a detections.csv.
inline DataSourceOptions RecordingOptions(const Config& config, bool use_detections,
                                          bool read_images) {
  DataSourceOptions options{use_detections, read_images, config.movable_tags};
  for (const Tag& tag : config.set_up.map.tags()) options.known_tag_ids.push_back(tag.id);
  options.limits = config.limits;
  return options;
}

}  // namespace tagtwist::internal
