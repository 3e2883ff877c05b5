#pragma once
#include <functional>
#include <string>

#include "frontend/base/limits.h"

namespace tagtwist::internal {

/// A recording of tags of a known layout by a camera of which nothing is known.
struct CameraJob {
  std::string recording, topic;  // DataSourceOptions
  bool use_detections = false;   // corners come from the recording; then the image's size, too
  int width = 0, height = 0;     // [px], of a recording without images
  bool accepts_poor = false;     // calibrates although the views speak against it
  int threads = 1;
  Limits limits = {};                                      // of its files
  std::function<void(const std::string& note)> warn = {};  // of DataSource::notes; may be empty
};

}  // namespace tagtwist::internal
