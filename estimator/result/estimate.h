#pragma once
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/noise_model.h"
#include "estimator/graph/trajectory.h"
#include "estimator/result/camera_share.h"
#include "estimator/result/imu_result.h"
#include "estimator/result/reprojection_errors.h"
#include "estimator/result/systematic_share.h"
#include "frontend/types/body_state.h"
#include "frontend/types/measurements.h"

namespace tagtwist {

/// How a frame came by its state.
enum class FrameStatus {
  kOk,         // tags of its own
  kHurried,    // tags of its own, but a deadline came before all was refined (window mode)
  kPredicted,  // no tag: tracks, neighbours and the motion prior
  kAmbiguous,  // two poses or turns are open: the state is the likelier, the covariance has both
  kNoFix,      // window mode, before the first tag or while two attitudes are open: no state
};
// "ok", "hurried", "predicted", "ambiguous", "no_fix"
const char* ToString(FrameStatus status);

/// One frame of the result. With kNoFix the state and covariance mean nothing.
struct FrameEstimate {
  int64_t t_ns = 0;
  FrameStatus status = FrameStatus::kNoFix;
  BodyState state;
  StateCovariance covariance = StateCovariance::Zero();  // error state of BodyState
  std::optional<PoseCovariance>
      pose_bound;  // of its own tags alone (error_bound.h), where they fix it
  ClosedForm closed_form;
  int n_tags = 0, n_tracks = 0;
};

enum class EstimateMode { kBatch, kSlidingWindow };
const char* ToString(EstimateMode mode);  // "batch", "sliding_window"

/// What was estimated, by a batch or by a sliding window.
struct Estimate {
  EstimateMode mode = EstimateMode::kBatch;
  std::vector<FrameEstimate> frames;  // one a frame; in window mode known at the frame's arrival
  std::vector<FrameEstimate> lagged;  // window mode: the same frames at the window's lag
  Trajectory trajectory;              // batch: to ask between the frames
  NoiseModel noise;
  std::optional<ImuResult> imu;            // batch: where it is in the estimate
  SystematicShare systematic;              // batch: in the covariances, beside the noise
  std::vector<double> reprojection_px;     // every corner's distance from its prediction [px]
  ReprojectionErrorsByPlace reprojection;  // window mode: at the window's lag
  std::vector<CameraShare> cameras;        // likewise, of a rig's, in order; of one camera none
  std::vector<std::string> warnings;       // one line each, for the person who runs it
};

/// What was estimated of one of several bodies.
struct BodyEstimate {
  std::string name;
  Estimate estimate;
};

}  // namespace tagtwist
