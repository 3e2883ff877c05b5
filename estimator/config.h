#pragma once
#include <string>

#include "estimator/estimator_options.h"
#include "frontend/front_end.h"
#include "frontend/types/camera.h"
#include "frontend/types/pose.h"
#include "frontend/types/result.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// All that a run is configured with.
struct Config {
  Camera camera;
  Pose cam_from_body;
  TagMap map;
  FrontEndOptions front_end;
  EstimatorOptions estimator;
};

/// The course's camera, extrinsic and mat, and the defaults of every options struct.
Config DefaultConfig();

/// Reads a configuration (docs/formats.md). Sections and keys that are left out keep their
/// defaults, those of DefaultConfig(); everything else must be right: an unknown or repeated key, a
/// wrong type, a value out of its range or a missing needed key is an error
/// "file:line: section.key: expected ..., got ...".
Result<Config> LoadConfig(const std::string& path);

}  // namespace tagtwist
