#pragma once
#include <functional>
#include <string>

#include "estimator/calibration/lens/lens_from_nothing.h"
#include "estimator/jobs/camera/camera_job.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Whom a live calibration talks to.
struct CameraGuide {
  std::function<void(const std::string& line)> tell;  // what it has, and what to show next
  std::function<bool()> stop;                         // asked before each frame
};

/// The lens of a live camera: keeps frames that differ from those kept (each with the next one),
/// tells what is still missing, and ends when the lens is good; told to stop, or where the camera
/// ends, by what there is, as FindCamera. Keeps 80 frames at most.
Result<LensFound> GuideCamera(const CameraJob& job, const TagMap& map, DataSource* camera,
                              const CameraGuide& guide);

}  // namespace tagtwist::internal
