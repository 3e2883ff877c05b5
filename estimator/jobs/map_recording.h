#pragma once
#include <string>

#include "estimator/calibration/mapping.h"
#include "estimator/online/config.h"

namespace tagtwist::internal {

/// A recording to make a map from.
struct MapJob {
  std::string recording;
  std::string topic;  // DataSourceOptions
  bool use_detections = false;
  int threads = 1;
  MappingOptions mapping;
};

/// Detects every tag of the family in the recording and maps them; of `config` camera and detector
/// are used. Errors name the recording.
Result<Mapping> MapRecording(const MapJob& job, const Config& config);

/// The tags that the configuration's map lacks, besides its own, which stay where they are. A size
/// that is not given is that of the map's tags.
Result<Mapping> MapUnknownTags(MapJob job, const Config& config);

}  // namespace tagtwist::internal
