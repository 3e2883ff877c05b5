#pragma once
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "estimator/online/config.h"
#include "estimator/result/estimate.h"
#include "frontend/base/result.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist {

/// How tags are found: kAuto is guided in the window where tags come from images and their patterns
/// are refined, else full.
enum class DetectionMode { kAuto, kFull, kGuided };

struct RunOptions {
  DetectionMode detection = DetectionMode::kAuto;
  bool sliding_window = false;
  bool use_detections = false;
  /// Window: each frame's state as soon as it is known.
  std::function<void(const FrameEstimate&)> on_state;
  size_t max_frames = std::numeric_limits<size_t>::max();
  int64_t duration_ns = std::numeric_limits<int64_t>::max();  // from the first frame's stamp
  std::optional<double> deadline_ms;                          // of a frame, window mode
  /// Live: milliseconds since the moment of a stamp.
  std::function<double(int64_t t_ns)> age_ms;
  int threads = 1;       // >= 1; the result does not depend on it
  bool progress = true;  // a bar on standard error, where that is a terminal
};

/// Estimates a whole recording, batch or window, with the time of every stage. An error when no
/// frame has a usable tag, naming `dataset`.
Result<Estimate> RunEstimate(const std::string& dataset, DataSource* source, const Config& config,
                             const RunOptions& options);

}  // namespace tagtwist
