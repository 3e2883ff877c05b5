#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "estimator/calibration/options.h"
#include "frontend/types/body_state.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Everything about the set-up that a calibration may change. Corners lie at
/// exp(log_scale) * (world_from_tag * corner); the ground truth at t + time_offset_s is
/// truth_from_world * world_from_cam(t) * cam_from_body.
struct CalibrationState {
  Camera camera;
  double log_scale = 0;    // of the print
  double line_time_s = 0;  // of a rolling shutter (RollingShutter)
  Pose cam_from_body, truth_from_world;
  double time_offset_s = 0;
  std::vector<Tag> tags;
};

/// Where the entries of a state's error state are: [lens (lens.h); log scale; line time; mount 6;
/// world 6; clock; 7 a tag: its pose and its bend]; poses as in pose.h.
constexpr int kTagEntries = 7;
struct CalibrationLayout {
  int lens_size = 0, n_tags = 0;
  int scale() const { return lens_size; }
  int line_time() const { return lens_size + 1; }
  int mount() const { return lens_size + 2; }
  int world() const { return mount() + 6; }
  int clock() const { return world() + 6; }
  int tag(int index) const { return clock() + 1 + kTagEntries * index; }
  int bend(int index) const { return tag(index) + 6; }
  int size() const { return tag(n_tags); }
};
CalibrationLayout LayoutOf(const CalibrationState& state);

CalibrationState Retract(const CalibrationState& state, const Eigen::VectorXd& step);
/// The inverse of Perturb: from `reference` to `state`, of one layout.
Eigen::VectorXd Difference(const CalibrationState& state, const CalibrationState& reference);

/// Parameters that are judged together.
enum class CalibrationGroup { kPinhole, kDistortion, kShutter, kMap, kBend, kTruth };
inline constexpr std::array kAllCalibrationGroups = {
    CalibrationGroup::kPinhole, CalibrationGroup::kDistortion, CalibrationGroup::kShutter,
    CalibrationGroup::kMap,     CalibrationGroup::kBend,       CalibrationGroup::kTruth};
const char* ToString(CalibrationGroup group);

/// One entry of the error state.
struct CalibrationParameter {
  CalibrationGroup group = CalibrationGroup::kPinhole;
  std::string name;        // "focal length", "mount x", "tag 7 x"
  std::string kind;        // the same for all tags: "tags x"
  std::string unit;        // "", "px", "m", "rad", "s"
  double prior_sigma = 0;  // 0: held
};
/// A description of every entry, with the options' priors.
std::vector<CalibrationParameter> ParametersOf(const CalibrationState& state,
                                               const CalibrationOptions& options);

/// A tag as a frame sees it.
struct CalibrationView {
  int tag = 0;  // into CalibrationState::tags
  std::array<Eigen::Vector2d, 4> pixels;
  OptionalApart<Eigen::Matrix<double, 8, 8>> covariance;  // the detection's own
  Eigen::Matrix<double, 8, 8> whitener = Eigen::Matrix<double, 8, 8>::Identity();  // of pixels
};

/// A frame: its pose is free, unless it is known, and nothing ties it to its neighbours. Copies
/// share the views.
struct CalibrationFrame {
  int64_t t_ns = 0;
  Pose world_from_cam;
  bool pose_known = false;
  std::optional<Twist> motion;  // of the camera, as RollingShutter takes it; absent: not known
  bool has_truth = false;
  std::shared_ptr<const std::vector<CalibrationView>> shared_views;

  const std::vector<CalibrationView>& views() const { return *shared_views; }
};

/// Between samples of the ground truth; farther apart they say nothing (see InterpolateTruth).
constexpr double kMaxTruthGapS = 0.1;

/// Standard deviations of the measurements.
struct CalibrationNoise {
  double corner_sigma_px = 0.3;  // of a corner's coordinate, beyond a detection's own covariance
  double truth_position_sigma_m = 0.005, truth_rotation_sigma_rad = 0.01;
  /// Errors of the ground truth that last over frames count as this many times greater ones: the
  /// square root of how many frames one error lasts, >= 1.
  double truth_position_persistence = 1, truth_rotation_persistence = 1;
};

/// What is estimated from: frames, ground truth, and the prior of the shared parameters.
struct CalibrationProblem {
  CalibrationState prior;
  Eigen::VectorXd prior_sigmas;  // of the error state; 0: held
  std::vector<CalibrationFrame> frames;
  std::vector<TruthSample> truth;
  double max_truth_gap_s = kMaxTruthGapS;
  double robust_scale = 2;  // Huber threshold of a block, in root mean squares
};

/// Whitens every view of the frames by that noise.
void SetCornerNoise(double sigma_px, std::vector<CalibrationFrame>* frames);

/// The frames' motion from the poses of their neighbours (their own counts where it is an end):
/// central differences, none where the nearer one is more than 0.2 s away. Frames in order of time.
void UpdateMotion(std::vector<CalibrationFrame>* frames);

/// The state with every held parameter back at the prior: where a search may start.
CalibrationState OnlyFree(const CalibrationState& state, const CalibrationProblem& problem);

/// The problem with only those parameters free that are in the groups; its frames those whose entry
/// in `use` is true (all when empty).
CalibrationProblem Restrict(const CalibrationProblem& problem,
                            const std::vector<CalibrationParameter>& parameters,
                            const std::vector<CalibrationGroup>& groups,
                            const std::vector<bool>& use = {});

}  // namespace tagtwist::internal
