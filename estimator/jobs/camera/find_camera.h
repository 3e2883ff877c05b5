#pragma once
#include <string>

#include "estimator/calibration/lens/lens_from_nothing.h"
#include "frontend/base/result.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// A recording of tags of a known layout by a camera of which nothing is known.
struct CameraJob {
  std::string recording, topic;  // DataSourceOptions
  bool use_detections = false;   // corners come from the recording; then the image's size, too
  int width = 0, height = 0;     // [px], of a recording without images
  bool accepts_poor = false;     // calibrates although the views speak against it
  int threads = 1;
};

/// Its lens: from libapriltag's corners first, then from those of the whole patterns, which need a
/// lens to be found. Looks at up to 80 places of the recording, two successive frames each. Views
/// that cannot tell a lens are refused before anything is calibrated. Errors name the recording.
Result<LensFound> FindCamera(const CameraJob& job, const TagMap& map);

}  // namespace tagtwist::internal
