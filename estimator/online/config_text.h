#pragma once
#include <string>

#include "estimator/online/config.h"

namespace tagtwist::internal {

/// The sections of a configuration behind camera, mount and map, as LoadConfig reads them: movable
/// tags where there are any, and all options. Each begins with an empty line.
std::string OptionsText(const Config& config);

/// The sections camera, cam_from_body and tag_map (every tag on a line), and the detector's; each
/// as LoadConfig reads it, with an empty line before it.
std::string CameraSectionText(const Config& config);
std::string MountSectionText(const Config& config);
/// The section cameras of a rig, in the others' place.
std::string CamerasSectionText(const Config& config);
std::string MapSectionText(const Config& config);
std::string DetectorSectionText(const Config& config);

}  // namespace tagtwist::internal
