#pragma once
#include <Eigen/Core>

#include "estimator/calibration/solver.h"

namespace tagtwist::internal {

/// Covariance of a solution's error state, full layout, as its own blocks of time say it. Residuals
/// that are alike from frame to frame say less than the white noise that solution.covariance is of:
/// the recording is left out block by block (delete-a-group jackknife to first order, Efron 1982;
/// for regressions CR3 of Cameron and Miller, A Practitioner's Guide to Cluster-Robust Inference,
/// 2015), and where the answers scatter by more than white noise does once in a hundred
/// recordings, a sigma is theirs (a lens's entries each by itself, the tags' kind by kind);
/// correlations stay. What priors leave open grows with nothing. Blocks last 2 s, more in long
/// recordings (at most 40 of them), less in short ones; with fewer than four of half a second, or
/// nothing free, it is solution.covariance.
Eigen::MatrixXd BlockCovariance(const CalibrationProblem& problem,
                                const CalibrationSolution& solution);

/// Second moment about the refined state of what the solution with all parameters free, and its
/// covariance, say of the truth: what was left out is not known better than that. No sigma is
/// greater than the prior's.
Eigen::MatrixXd AboutRefined(const Eigen::MatrixXd& covariance, const CalibrationState& refined,
                             const CalibrationState& all, const Eigen::VectorXd& prior_sigmas);

/// What is known of a refined state's errors.
struct KnownSigmas {
  Eigen::MatrixXd covariance;    // of the error state, full layout; zero where held
  Eigen::VectorXd prior_sigmas;  // 0: held
  bool has_truth = false;
};

/// Standard deviation of each coordinate of a tag's centre [m], root mean square over the tags that
/// are refined, 0 where none is. Without ground truth nothing but the priors of the tags tells
/// where the map as a whole is: then it is the world, and has no error.
double TagSigma(const CalibrationState& refined, const KnownSigmas& known);

/// RigCamera::covariance of a camera that was refined: lens and mount, each that was held as
/// `given` has it.
Eigen::MatrixXd CameraCovariance(const CalibrationState& refined, const KnownSigmas& known,
                                 const Eigen::MatrixXd& given);

}  // namespace tagtwist::internal
