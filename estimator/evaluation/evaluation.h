#pragma once
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "estimator/evaluation/alignment_types.h"
#include "estimator/evaluation/pose_series.h"
#include "frontend/base/result.h"
#include "frontend/types/body_state.h"

namespace tagtwist {

struct EvaluationOptions {
  AlignmentOptions alignment;
  size_t rpe_frames = 1;     // step of the relative error in frames, >= 1
  double rpe_seconds = 1.0;  // in time [s], > 0
  double rpe_metres = 1.0;   // and along the estimate's path [m], > 0
};

/// Figures of one 3-D error over frames; every figure is of its norm.
struct ErrorStatistics {
  size_t count = 0;
  double rmse = 0, mean = 0, median = 0, max = 0;
};
ErrorStatistics Summarise(std::vector<double> norms);

/// Error of the motion between two frames: inverse(truth motion) * estimated motion.
struct RelativeError {
  ErrorStatistics translation_m, rotation_rad;
};

/// Normalised estimation error squared, e' P^-1 e, averaged over frames. `band` holds the mean with
/// probability 0.95 when P is right and the frames' errors are independent; neighbouring frames'
/// errors are not, so an honest mean may lie a little outside.
struct MeanNees {
  int dof = 0;
  size_t count = 0;
  double mean = 0;  // expected: dof
  double band_low = 0, band_high = 0;
  double per_dof() const { return mean / dof; }
};

/// RMSE over the root mean square of the printed 3-D standard deviations (ErrorBound): 1 where the
/// estimate reaches the bound that its covariance states.
struct BoundRatio {
  double position = 0, rotation = 0;
  std::optional<double> velocity, rate;
};

/// What a trajectory is worth. The entries that the truth, or the trajectory, cannot answer are
/// absent.
struct Accuracy {
  size_t frames = 0;   // of the trajectory
  size_t matched = 0;  // of them with truth
  Alignment alignment;
  ErrorStatistics position_m, rotation_rad;                         // ATE
  std::optional<RelativeError> rpe_frames, rpe_time, rpe_distance;  // RPE
  std::optional<ErrorStatistics> velocity_mps;                      // in W
  std::optional<ErrorStatistics> rate_radps;                        // in B
  std::optional<MeanNees> nees, nees_pose, nees_twist;  // 12, 6 and 6 degrees of freedom
  std::optional<BoundRatio> rmse_over_bound;            // where every frame has a covariance
};

/// Judges a trajectory. The figures agree with the tool evo: ATE is its APE (translation part,
/// angle in radians) after its alignment without scale, RPE its RPE over all pairs of frames. An
/// error when no pose has truth, or too few for the alignment.
Result<Accuracy> Evaluate(const PoseSeries& series, const std::vector<TruthSample>& truth,
                          const EvaluationOptions& options);

}  // namespace tagtwist
