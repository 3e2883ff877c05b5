#pragma once
#include <memory>
#include <string>
#include <vector>

#include "estimator/online/config.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

/// How a recording is opened that is estimated with this configuration: ids that neither the map
/// nor the list of movable tags has are errors in a detections.csv.
inline DataSourceOptions RecordingOptions(const Config& config, bool use_detections,
                                          bool read_images) {
  DataSourceOptions options{use_detections, read_images, config.movable_tags};
  const TagMap all_tags = config.AllTags();
  for (const Tag& tag : all_tags.tags()) options.known_tag_ids.push_back(tag.id);
  options.limits = config.limits;
  return options;
}

/// OpenDataSource, or, where the configuration has several cameras, OpenRigSource of their
/// recordings: in this folder, or in mav0 of it (EuRoC), or, of a bag, their topics of it.
Result<std::unique_ptr<DataSource>> OpenRecording(const std::string& dataset, const Config& config,
                                                  const DataSourceOptions& options);

}  // namespace tagtwist::internal
