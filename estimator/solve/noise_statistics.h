#pragma once
#include <vector>

#include "estimator/graph/graph.h"
#include "estimator/graph/linear_system.h"
#include "estimator/graph/noise_model.h"
#include "estimator/linear/block_banded.h"
#include "frontend/base/for_ranges.h"

namespace tagtwist::internal {

class QuadraticChain;

/// Sum of squares of one noise source in its unit (px^2; per unit of density) against the degrees
/// of freedom that speak of it. MacKay's evidence fixed point: variance = sum / dof, where dof =
/// number of residuals - tr(J P J'), P the posterior covariance (MacKay, Bayesian Interpolation,
/// 1992, Eq. 4.9; for process noise the residuals are those of the motion prior).
struct VarianceStatistic {
  double sum = 0, dof = 0;
  VarianceStatistic& operator+=(const VarianceStatistic& other) {
    sum += other.sum;
    dof += other.dof;
    return *this;
  }
  VarianceStatistic operator*(double factor) const { return {factor * sum, factor * dof}; }
};

/// The same of the shake's share of a motion's noise, and of the rest, each in units of its own
/// variance: the sum is as large as the degrees of freedom where the shake is as the prior has it.
struct ShakeStatistic {
  VarianceStatistic shake, rest;
  ShakeStatistic& operator+=(const ShakeStatistic& other) {
    shake += other.shake;
    rest += other.rest;
    return *this;
  }
  ShakeStatistic operator*(double factor) const { return {shake * factor, rest * factor}; }
};

/// Statistics of all sources.
struct NoiseStatistics {
  VarianceStatistic corner, track, linear, angular;
  ShakeStatistic linear_shake, angular_shake;
  double motion_s = 0, motions = 0;  // time that the motion is taken over, in so many steps
  NoiseStatistics& operator+=(const NoiseStatistics& other) {
    corner += other.corner;
    track += other.track;
    linear += other.linear;
    angular += other.angular;
    linear_shake += other.linear_shake;
    angular_shake += other.angular_shake;
    motion_s += other.motion_s;
    motions += other.motions;
    return *this;
  }
  NoiseStatistics operator*(double factor) const {
    return {corner * factor,       track * factor,         linear * factor,   angular * factor,
            linear_shake * factor, angular_shake * factor, motion_s * factor, motions * factor};
  }
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

/// The motion from a state to the next.
struct MotionStep {
  int state = 0;
  double dt_s = 0;
  bool tells_shake = false;  // its start sees several tags: a lone one's errors look like it
};
/// Adds the statistic of a motion, linearised.
void AddMotionStatistic(const LinearFactor& linear, const BlockBandedMatrix& covariance,
                        const MotionStep& step, const NoiseModel& noise, NoiseStatistics* out);

/// ComputeNoiseStatistics of all states of a chain: tags by their forms as they are, where these
/// tell all that is asked.
NoiseStatistics ComputeNoiseStatistics(const QuadraticChain& chain,
                                       const BlockBandedMatrix& covariance, const NoiseModel& noise,
                                       const ForRanges& for_ranges);

}  // namespace tagtwist::internal
