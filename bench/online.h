#pragma once
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bench/cpu_clock.h"
#include "estimator/online/config.h"
#include "estimator/online/online_estimator.h"
#include "frontend/front_end.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/simulation/simulator.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/tags/tag_sweep.h"

namespace tagtwist::internal {

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

/// What tagtwist_estimate measures of a frame for a batch: tags found in pieces of the flight,
/// tracks and closed form. A frame's time is its share of its piece's.
class PiecesMethod {
 public:
  static Result<PiecesMethod> Create(const Config& config);
  void Add(const SimulatedFrame& frame);
  /// After the last frame.
  void Finish();
  const MethodRun& run() const { return run_; }

 private:
  PiecesMethod(Config config, std::unique_ptr<CornerRefiner> refiner, TagSweep sweep);

  Config config_;
  std::unique_ptr<CornerRefiner> refiner_;  // stays where it is: the sweep refers to it
  TagSweep sweep_;
  FrontEnd front_end_;
  std::vector<SweepImage> piece_;
  MethodRun run_;
};

/// tagtwist_estimate --sliding_window, from image to state, with --detection guided or full.
class OnlineMethod {
 public:
  static Result<OnlineMethod> Create(const Config& config, bool guided);
  Status Add(const SimulatedFrame& frame);
  const MethodRun& run() const { return run_; }
  /// Milliseconds of every frame by stage.
  std::vector<std::pair<std::string, std::vector<double>>> stages() const;

 private:
  // What the estimator tells of its stages; it stays where it is.
  struct Stages {
    std::optional<CpuClock> since_last;
    std::vector<double> detect_ms, track_ms, seed_ms, window_ms;
    void Add(FrameStage stage);
  };
  OnlineMethod(OnlineEstimator estimator, std::unique_ptr<Stages> stages);

  std::unique_ptr<Stages> stages_;
  OnlineEstimator estimator_;
  MethodRun run_;
};

}  // namespace tagtwist::internal
