#pragma once
#include <cstdint>
#include <optional>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/graph/graph_state.h"
#include "estimator/motion/bank/motion_banks.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// What the tags of frames say of one part of a motion, its attitude (in B) or its position (in W),
/// beyond the smoothed states: r by which a frame's tags have the pose elsewhere, of which the
/// tags' own noise makes R. Sums over frames; each counts by 1 / tr R, so that near and far ones
/// may be together.
struct UnfollowedPart {
  double frames = 0, squares = 0;  // of what each counts, 1 unless faded, the squares
  double weight = 0, pairs = 0, weight_of_pairs = 0, dt2_s2 = 0;
  Eigen::Matrix3d square = Eigen::Matrix3d::Zero();  // r r'
  Eigen::Matrix3d noise = Eigen::Matrix3d::Zero();   // R
  Eigen::Matrix3d next = Eigen::Matrix3d::Zero();    // r of a frame times that of the next

  /// As many that are not faded say as much.
  double AsMany() const { return frames * frames / squares; }
  UnfollowedPart& operator+=(const UnfollowedPart& other);
  UnfollowedPart& operator*=(double by);
};

/// By how much a frame's tags have the pose elsewhere than its smoothed state, the covariance of
/// that by their noise, and what of their corners no pose explains, beside its degrees of freedom.
struct ShownPose {
  int64_t t_ns = 0;
  PoseStep step = PoseStep::Zero();
  PoseCovariance noise = PoseCovariance::Zero();
  double among_tags = 0, freedom = 0;
};
/// nullopt where fewer than two tags show it, or do not tell its attitude to 2 degrees.
std::optional<ShownPose> ShownBy(const EstimatorSetup& setup, double corner_sigma_px, int64_t t_ns,
                                 const Pose& state, const std::vector<TagDetection>& tags);

/// Motion that the states do not follow: too small beside the noise of one frame, and too fast for
/// the motion's prior, as a vibration or the slips of a stage are. Over many frames it shows as
/// more scatter of what their tags say than their noise makes, or as scatter of which the next
/// frame has some, too. The smoothed states then have its mean square more of variance, and their
/// rates that of its change from a frame to the next,
///
///   D = E[r r'] - R,    2 (D - E[r r_next']) / dt^2,
///
/// and what chance may hide of either. Where motion is followed nothing stands out, and nothing is
/// added. R is known by what a frame's tags say of one another: the noise that states were solved
/// with has the motion that they do not follow in it.
class UnfollowedMotion {
 public:
  /// Of a frame later than the last one.
  void Add(const ShownPose& shown);
  /// The frames so far count less: by that factor.
  void Fade(double by);
  UnfollowedMotion& operator+=(const UnfollowedMotion& other);
  /// Of those parts alone; if it is there in one of them it is asked of each.
  StateCovariance Covariance(const MotionParts& of) const;

 private:
  double among_tags_ = 0, freedom_ = 0;
  UnfollowedPart attitude_, position_;
  std::optional<ShownPose> last_;
};

/// Of the frames that left a window: of some seconds, or, where they show none, of more.
class UnfollowedByWindow {
 public:
  void Add(const ShownPose& shown, const MotionParts& of);
  /// Of the parts that Add was told.
  const StateCovariance& Covariance() const { return covariance_; }

 private:
  UnfollowedMotion near_, wide_;
  StateCovariance covariance_ = StateCovariance::Zero();
};

/// Adds to each state's covariance, of batch, what the frames around it leave unfollowed.
void AddUnfollowedMotion(const EstimatorSetup& setup, double corner_sigma_px, const MotionParts& of,
                         const std::vector<GraphState>& states,
                         const std::vector<GraphFrame>& frames,
                         std::vector<StateCovariance>* covariances);

}  // namespace tagtwist::internal
