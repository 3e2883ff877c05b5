#pragma once
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/graph/trajectory.h"
#include "estimator/imu/imu_solve.h"
#include "estimator/imu/surer_states.h"
#include "estimator/result/estimate.h"
#include "estimator/solve/quadratic_chain.h"
#include "estimator/window/imu/calibration_border.h"
#include "estimator/window/imu/imu_learning.h"
#include "estimator/window/window_output.h"

namespace tagtwist::internal {

/// An IMU in the states of a window. The window of tags goes on by itself, chooses the tags and
/// starts anew where it must; beside it the same frames and those without tags are a chain with the
/// IMU's factors, whose states take the place of the window's where they are surer (SurerStates).
/// It begins with the calibration that the frames of the first second say (SolveWithImu), which is
/// then estimated with the states (CalibrationBorder), and anew with what more frames say of the
/// IMU's noise. What contradicts the tags, has a hole, or is too uncertain ends the chain; the next
/// state by tags begins another.
class WindowImu {
 public:
  WindowImu(EstimatorSetup setup, const ImuOptions& options);

  /// Stamps must grow; those around a frame come before it, as far as they are there.
  void AddSamples(const std::vector<ImuSample>& samples);
  /// `out` is what the window of tags says of the frame, and becomes what both say.
  void AddTo(const FrameMeasurements& measurement, const NoiseModel& noise, WindowOutput* out);
  /// Frames at the lag, in order.
  void AddTo(std::vector<FrameEstimate>* lagged);
  /// At a stamp that the samples reach; nullopt while there is no chain.
  std::optional<StateAndCovariance> PredictAt(int64_t t_ns) const;
  /// Why the window goes without it, or nothing.
  std::optional<std::string> Warning() const;
  const std::optional<ImuResult>& found() const { return found_; }

 private:
  // A frame of the chain as it was when it left.
  struct Left {
    int64_t t_ns = 0;
    BodyState state;
    StateCovariance covariance;
    bool has_tags = false;
  };

  void HoldUntil(int64_t t_ns);
  void BeginLearned(ImuSolution solved, const NoiseModel& noise);
  void TakeCalibration();
  void Begin(const GraphFrame& frame, const Block& covariance, const NoiseModel& noise);
  void BeginFromTags(const FrameEstimate& by_tags, std::vector<TagDetection> tags,
                     const NoiseModel& noise);
  bool Extend(const FrameMeasurements& measurement, const NoiseModel& noise,
              const std::vector<int>& used);
  std::vector<TagDetection> TagsNear(const GraphFrame& frame, const Block& covariance,
                                     const std::vector<TagDetection>& tags,
                                     const std::vector<int>& used) const;
  bool IsUseless() const;
  bool Contradicts(const NoiseModel& noise) const;
  void End();
  void LetOldestLeave();
  void TakeInto(SurerStates* surer, FrameEstimate* frame) const;
  void DropOldSamples();

  EstimatorSetup setup_;
  ImuOptions options_;
  ImuLearning learning_;
  std::optional<ImuModel> model_;
  std::optional<ImuResult> found_;
  CalibrationBorder border_;
  std::vector<ImuSample> samples_, in_body_;  // since the chain's oldest frame
  Acceleration biases_;                       // of the newest frame of the last chain
  Block bias_covariance_;                     // with zeros but for them
  std::vector<GraphFrame> frames_;            // of the chain; none: there is no chain
  QuadraticChain chain_;
  BlockBandedMatrix covariance_{0, 0};
  std::deque<Left> left_;  // not yet told at the lag
  SurerStates at_arrival_, at_lag_;
};

}  // namespace tagtwist::internal
