#pragma once
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core/mat.hpp>
#include <string>
#include <vector>

#include "estimator/calibration/lens/lens_from_nothing.h"
#include "estimator/calibration/lens/views.h"
#include "estimator/jobs/camera/camera_job.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// What a live calibration has when it has looked at a frame.
struct GuideView {
  int64_t t_ns = 0;
  cv::Mat image;                               // 8-bit gray
  std::vector<TagDetection> tags;              // of the frame, that count
  size_t kept = 0;                             // frames
  ViewsJudged seen;                            // their corners, by cell; nothing else
  std::string words;                           // what it said last: what it has, what to show next
  bool is_calibrating = false;                 // by what is kept; the words come when it is done
  std::shared_ptr<const LensFound> lens = {};  // the latest that was found, good or not
};

/// Whom a live calibration talks to.
struct CameraGuide {
  std::function<void(const std::string& line)> tell;  // what it has, and what to show next
  std::function<bool()> stop;                         // asked before each frame
  /// Every frame. Where it is asked for, lenses are found beside the frames, in a thread of their
  /// own, and by views that are not good yet, too: whoever watches sees what they tell.
  std::function<void(const GuideView& view)> show = {};
};

/// The lens of a live camera: keeps frames that differ from those kept (each with the next one),
/// tells what is still missing, and ends when the lens is good; told to stop, or where the camera
/// ends, by what there is, as FindCamera. Keeps 80 frames at most: then every second one makes
/// room.
Result<LensFound> GuideCamera(const CameraJob& job, const TagMap& map, DataSource* camera,
                              const CameraGuide& guide);

}  // namespace tagtwist::internal
