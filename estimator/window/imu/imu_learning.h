#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/imu/imu_solution.h"
#include "estimator/imu/imu_solver.h"
#include "estimator/window/window_output.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// The tags of a frame that its state was made with.
std::vector<TagDetection> TagsOfState(const FrameMeasurements& measurement,
                                      const WindowOutput& out);

/// Learns an IMU's calibration and noise from the frames of a window as they come: SolveWithImu of
/// those until then after 1, 2, 4, 8, 16 and 32 s, its noise by the likelihood after 4 and 16;
/// longer where it is not known well enough. It is worked out over the frames that follow, a piece
/// at each (ImuSolver). Few enough frames are kept.
class ImuLearning {
 public:
  explicit ImuLearning(const ImuOptions& options) : imu_{options, {}} {}

  bool goes_on() const { return goes_on_; }
  void Add(const ImuSample& sample);
  /// What the window says of a frame. A solution of frames before it, where one has been worked out
  /// and is known well enough.
  std::optional<ImuSolution> Add(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const FrameMeasurements& measurement, const WindowOutput& out);
  /// Why there is none yet.
  const std::string& refusal() const { return refusal_; }

 private:
  std::optional<ImuSolution> GoOn();
  void Keep(const FrameMeasurements& measurement, const WindowOutput& out);
  void ThinOut();
  void DropBefore(int64_t t_ns);

  ImuRecord imu_;
  std::vector<GraphFrame> kept_;
  std::optional<ImuModel> model_;  // of the last solution
  int64_t kept_spacing_ns_ = 80'000'000;
  std::optional<ImuSolver> solver_;
  double solved_s_ = 0;  // that its frames span
  int turn_ = 0;         // solved so many times
  double next_s_ = 1;    // after the first of them
  bool goes_on_ = true;
  std::string refusal_ = "less than a second of frames with tags came with it";
};

}  // namespace tagtwist::internal
