#pragma once
#include "estimator/calibration/lens/lens_from_nothing.h"
#include "estimator/jobs/camera/camera_job.h"
#include "frontend/base/result.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The recording's lens: from libapriltag's corners first, then from those of whole patterns, which
/// need a lens to be found. Looks at up to 80 places of the recording, two successive frames each.
/// Views that cannot tell a lens are refused before anything is calibrated. Errors name the
/// recording.
Result<LensFound> FindCamera(const CameraJob& job, const TagMap& map);

}  // namespace tagtwist::internal
