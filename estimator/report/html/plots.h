#pragma once
#include <cstdint>
#include <vector>

#include "estimator/evaluation/evaluation.h"
#include "estimator/evaluation/pose_series.h"
#include "estimator/report/html/page.h"

namespace tagtwist::internal {

/// A trajectory to plot; with covariance it gets 3-sigma bands.
struct PlottedSeries {
  size_t slot = 1;  // slot 0 is the ground truth's
  PoseSeries series;
  Alignment alignment;  // what its Accuracy was made with
};

/// What the plots over time are made of.
struct PlotInput {
  std::vector<int64_t> stamps_ns;  // growing; every series' stamps are among them
  int64_t t0_ns = 0;               // zero of the time axis
  std::vector<PlottedSeries> series;
  std::vector<TruthSample> truth;  // may be empty
  double max_truth_gap_s = 0.1;
  bool connect = false;  // see Plot
};

/// Sections "Position", "Attitude" (Euler angles Z-X-Y: roll, pitch, yaw), "Velocity" and "Rates"
/// over time, each with three plots, and with truth the same four as errors. Estimates are shown in
/// the truth's frames, that is, aligned.
std::vector<ReportSection> TrajectorySections(const PlotInput& input);

/// Angle rates of roll, pitch, yaw per body rate, so that their covariance follows from that of
/// theta; not finite where roll is +-90 degrees.
Eigen::Matrix3d ZxyRatesFromBodyRates(const Eigen::Vector3d& roll_pitch_yaw);

}  // namespace tagtwist::internal
