#pragma once
#include <optional>
#include <vector>

#include "estimator/graph/estimator_options.h"
#include "estimator/graph/graph.h"
#include "estimator/graph/linear_system.h"
#include "estimator/graph/noise_model.h"
#include "estimator/linear/block_banded.h"
#include "estimator/result/estimate.h"

namespace tagtwist::internal {

/// Sum of squares of one noise source in its unit (px^2; per unit of density) against the degrees
/// of freedom that speak of it. MacKay's evidence fixed point: variance = sum / dof, where dof =
/// number of residuals - tr(J P J'), P the posterior covariance (MacKay, Bayesian Interpolation,
/// 1992, Eq. 4.9; for process noise the residuals are those of the motion prior).
struct VarianceStatistic {
  double sum = 0, dof = 0;
  VarianceStatistic& operator+=(const VarianceStatistic& other);
  VarianceStatistic operator*(double factor) const { return {factor * sum, factor * dof}; }
};

/// Statistics of all four sources.
struct NoiseStatistics {
  VarianceStatistic corner, track, linear, angular;
  double motion_s = 0, motions = 0;  // time that the motion is taken over, in so many steps
  NoiseStatistics& operator+=(const NoiseStatistics& other);
  NoiseStatistics operator*(double factor) const;
};

/// Which states a statistic is taken over: tags and tracks seen from states in [first, last), and
/// the motion from each of those to the next.
struct StateRange {
  int first = 0, last = 0;
};

/// Statistics at the solution of a graph that was built with `noise`; `covariance` is the selected
/// inverse of its normal equations. Tags far off for the spread that most tags show are left out.
NoiseStatistics ComputeNoiseStatistics(const Graph& graph, const BlockBandedMatrix& covariance,
                                       const NoiseModel& noise, const StateRange& range);

/// The parts that it is made of. Scale of the tags' chi-square that most of them show, robust: 1
/// where the noise model is right. Squared norms of their whitened residuals.
double TypicalTagScale(std::vector<double> squared_norms);
/// The squared norm above which a tag is far off, at that scale.
double MostOfInlierTag(double typical_scale);
/// The statistic of one tag: its whitener, whitened residual and Jacobian in the pose without a
/// robust weight; the pose's covariance; s2 the variance that is learned [px^2].
VarianceStatistic TagStatistic(const Eigen::Matrix<double, 8, 8>& whitener,
                               const Eigen::Matrix<double, 8, 1>& residual,
                               const Eigen::Matrix<double, 8, 6>& jacobian,
                               const Eigen::Matrix<double, 6, 6>& pose_covariance, double s2);
/// Adds the statistic of the motion from state k on, linearised.
void AddMotionStatistic(const LinearFactor& linear, const BlockBandedMatrix& covariance, int k,
                        const NoiseModel& noise, NoiseStatistics* out);

/// Whether the options leave open what of the motion is white noise.
bool MotionPriorIsOpen(const EstimatorOptions& options);

/// Whether both densities of the motion prior are learned.
bool MotionIsLearned(const EstimatorOptions& options);

/// Whether the options leave any noise to be learned where there are no tracks.
bool AnyNoiseIsOpen(const EstimatorOptions& options);

/// Noise to begin with: given values, defaults elsewhere; source "default" or "given". Where the
/// options leave the motion prior open it is `open`.
NoiseModel InitialNoise(const EstimatorOptions& options, WhiteNoiseOn open = WhiteNoiseOn::kJerk);

/// Noise from statistics, given values kept; a step changes a parameter at most tenfold. A source
/// with fewer than `least_dof` degrees of freedom keeps its value. A density stays above where its
/// information would drown the measurements' in rounding.
NoiseModel UpdateNoise(const NoiseModel& noise, const NoiseStatistics& statistics,
                       const EstimatorOptions& options, double least_dof = 1);

/// Largest change of a parameter between two models, as |log ratio| of standard deviations.
double NoiseChange(const NoiseModel& a, const NoiseModel& b);

}  // namespace tagtwist::internal
