#pragma once
#include <string>

#include "estimator/online/config.h"
#include "estimator/result/estimate.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal {

struct OverlayOptions {
  std::string file;             // .mp4 or .avi
  bool use_detections = false;  // tags are the recording's own
  int threads = 1;
};

/// An error where no image is to be drawn on, told before an estimate takes its time: the
/// recording's first frame has none, or the file cannot be a video's. Takes that frame of `source`.
Status CheckOverlay(const std::string& dataset, const OverlayOptions& options, DataSource* source);

/// A video of the recording: on each image its tags, tracks, the map as the estimate's state puts
/// it there, and a line of the state. `source` starts anew; one frame each of the estimate's, which
/// are searched in full, whatever way the estimate found its tags. Whole or not at all.
Status WriteOverlay(const OverlayOptions& options, const Config& config, const Estimate& estimate,
                    DataSource* source);

}  // namespace tagtwist::internal
