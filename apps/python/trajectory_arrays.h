#pragma once
#include <optional>
#include <string>
#include <vector>

#include "apps/python/python_types.h"
#include "estimator/evaluation/pose_series.h"
#include "estimator/result/estimate.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal::python {

/// tagtwist.Trajectory: poses of the body in W, N of them, and where they are known twists and
/// covariances; NaN in the rows that lack something. Shapes and frames: docs/python.md.
struct TrajectoryArrays {
  IntArray t_ns;              // (N,)
  Array position;             // (N, 3)
  Array quaternion;           // (N, 4) x y z w, w >= 0
  Array linear_velocity;      // (N, 3) in W
  Array angular_velocity;     // (N, 3) in B
  Array covariance;           // (N, 12, 12)
  py::array Seconds() const;  // (N,)
};

/// tagtwist.States: what an estimate says of its frames.
struct StatesArrays : TrajectoryArrays {
  py::object status;  // (N,) str
  IntArray n_tags, n_tracks;
  TrajectoryArrays closed_form;  // the same N frames
};

/// tagtwist.State: one frame of a body.
struct StateArrays {
  int64_t t_ns = 0;
  std::string status;
  Array position, quaternion, linear_velocity, angular_velocity, covariance;
  int n_tags = 0, n_tracks = 0;
  std::string body = "body";
};

StatesArrays ToStates(const std::vector<FrameEstimate>& frames);
StateArrays ToState(const FrameEstimate& frame, const std::string& body = "body");
TrajectoryArrays ToTrajectory(const std::vector<TruthSample>& truth);

/// The rows that have a pose, with what else is known there.
PoseSeries ToSeries(const TrajectoryArrays& trajectory);
std::vector<TruthSample> ToTruth(const TrajectoryArrays& trajectory);

}  // namespace tagtwist::internal::python
