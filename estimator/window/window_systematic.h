#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <deque>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/noise_model.h"
#include "estimator/result/estimate.h"
#include "estimator/systematic/lasting_errors.h"
#include "estimator/window/window_output.h"

namespace tagtwist::internal {

/// What a frame's own tags say of its pose: their information, and a square root of the second
/// moment of what lasting errors push it by (6 x columns of LastingErrors).
struct PosePush {
  int64_t t_ns = 0;
  PoseCovariance information = PoseCovariance::Zero();
  Eigen::MatrixXd push;
};

/// What errors that last do to the poses of consecutive frames: the shift that each frame's own
/// tags would have by them, averaged with its neighbours' over as many frames as its covariance
/// says that it draws on, and the change of it as a shift of the twist.
class SystematicShift {
 public:
  /// Adds what is known of these errors to the frame's covariance. Stamps grow; one without a state
  /// begins anew. `later`: frames after it that its estimate draws on, from the next one on.
  void AddTo(const PosePush& own, const std::deque<PosePush>& later, FrameEstimate* frame);

 private:
  PosePush faded_;  // frames until the last one
  Eigen::MatrixXd shift_;
};

/// Errors that last in the covariances of a window: frame after frame, at its arrival and at the
/// lag.
class WindowSystematic {
 public:
  explicit WindowSystematic(const EstimatorSetup& setup) : errors_(setup) {}

  void AddTo(const FrameMeasurements& measurement, const NoiseModel& noise, WindowOutput* out);
  /// Frames at the lag, in order.
  void AddTo(std::vector<FrameEstimate>* lagged);

 private:
  // A frame that is not yet told at the lag.
  struct Seen {
    int64_t t_ns = 0;
    Pose world_from_body;            // at its arrival
    std::vector<TagDetection> tags;  // that it was made with: none where it has no state
  };
  void Learn(const NoiseModel& noise, const std::vector<FrameEstimate>& lagged);
  void PushAnew(const NoiseModel& noise);
  PosePush PushOf(const Seen& seen, const NoiseModel& noise) const;
  // Its push, where errors are known.
  std::optional<PosePush> TakeOldest();

  LastingErrors errors_;
  SystematicShift at_arrival_, at_lag_;
  std::deque<Seen> seen_;
  std::deque<PosePush> pushes_;  // of these frames, where errors are known
};

}  // namespace tagtwist::internal
