#pragma once
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimator/online/config.h"
#include "estimator/window/sliding_window.h"
#include "frontend/front_end.h"
#include "frontend/simulation/simulator.h"
#include "frontend/tags/tag_follower.h"

namespace tagtwist {

/// What a method took and how well it did, over all frames.
struct MethodRun {
  std::vector<double> frame_ms;  // CPU time of the thread
  size_t tags = 0;
  int posed = 0;                                              // frames with a pose
  double squared_position_m2 = 0, squared_velocity_mps2 = 0;  // sums of squared errors
};

/// libapriltag's own detection with quad_decimate 1, and on demand the pose of all its corners by
/// cv::solvePnP.
class PlainMethod {
 public:
  static Result<PlainMethod> Create(const Config& config, bool with_pose);
  void Add(const SimulatedFrame& frame);
  const MethodRun& run() const { return run_; }

 private:
  PlainMethod(Config config, TagDetector detector, bool with_pose)
      : config_(std::move(config)), detector_(std::move(detector)), with_pose_(with_pose) {}
  std::optional<Pose> SolvePose(const std::vector<TagDetection>& tags) const;

  Config config_;
  TagDetector detector_;
  bool with_pose_;
  MethodRun run_;
};

/// tagtwist_estimate --sliding_window, from image to state, with --detection guided or full.
class OnlineMethod {
 public:
  static Result<OnlineMethod> Create(const Config& config, bool guided);
  Status Add(const SimulatedFrame& frame);
  const MethodRun& run() const { return run_; }
  /// Milliseconds of every frame by stage.
  std::vector<std::pair<std::string, std::vector<double>>> stages() const {
    return {{"detection", detect_ms_},
            {"tracks", track_ms_},
            {"seed", seed_ms_},
            {"window", window_ms_}};
  }

 private:
  OnlineMethod(const Config& config, bool guided, TagDetector detector, CornerRefiner refiner,
               TagFollower follower);
  std::vector<TagDetection> FindTagsOf(const SimulatedFrame& frame);

  Config config_;
  bool guided_;
  TagDetector detector_;  // where it is not guided
  CornerRefiner refiner_;
  TagFollower follower_;
  FrontEnd front_end_;
  SlidingWindow window_;
  MethodRun run_;
  std::vector<double> detect_ms_, track_ms_, seed_ms_, window_ms_;
};

}  // namespace tagtwist
