#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <deque>

#include "estimator/motion/tags_alone.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// A vibration that is faster than the frames show (motors, legs, a rough road): the poses jump to
/// and fro from frame to frame, and whatever velocity the states take from that is not the body's.
/// The poses hold; of the twist is known no more than how large the vibration is, and so its
/// variance grows.
///
/// It is told by third differences of the poses that the tags of the latest frames say alone, from
/// frame to frame and from every second frame to the next but one. What a body does of its own is
/// the less the faster: there the latter are ten and more times as large, in their squares. Slower
/// than a quarter of the frames' rate, as it seems in the frames, a vibration tells itself by
/// nothing.
class FastVibration {
 public:
  /// The next frame. Stamps must grow.
  void Add(int64_t t_ns, const PoseMeasurement& pose);

  /// What the variances of a twist lack (v_world, omega_body; the pose's are 0); zero where the
  /// latest frames, about 60, show no such vibration.
  const StateVector& variances() const { return variances_; }

  // Of position or attitude.
  struct Third {
    Eigen::Vector3d plain = Eigen::Vector3d::Zero(), whitened = plain;  // by a pose's covariance
    double noise = 0;        // variance of a coordinate of a pose, by its tags
    double information = 0;  // and the inverse of it, in the mean
  };
  struct Thirds {
    std::array<Third, 2> parts;
    int n_even = 0;  // that came before it in even steps
  };

 private:
  void Judge(double interval_s);

  int64_t last_ns_ = 0;
  Pose last_;
  double interval_s_ = 0;
  int n_even_ = 0;                                 // frames that came evenly, up to this one
  std::array<Eigen::Vector3d, 2> first_, second_;  // differences up to the last frame
  std::deque<Thirds> thirds_;                      // of the latest frames
  StateVector variances_ = StateVector::Zero();
};

}  // namespace tagtwist::internal
