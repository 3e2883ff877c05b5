#pragma once
#include <string>
#include <vector>

#include "estimator/evaluation/pose_series.h"
#include "estimator/result/estimate.h"
#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// states.csv, a row a frame (SI units, frames as the column names say): the state, the closed
/// form's pose and low-passed twist, standard deviations of the error state, counts, status. Cells
/// are empty where there is nothing: the state of a frame without one, the closed form where it has
/// no answer. Quaternions have qw >= 0.
std::string FormatStatesCsv(const std::vector<FrameEstimate>& frames);
/// Its lines one by one, each with its end.
std::string StatesCsvHeader();
std::string FormatStatesRow(const FrameEstimate& frame);

/// covariance.csv: t and the upper triangle of the covariance of the error state
/// [theta, p, v_world, omega_body], row by row; columns rx_rx, rx_ry, ... wz_wz. Frames without a
/// state are left out.
std::string FormatCovarianceCsv(const std::vector<FrameEstimate>& frames);
/// A line of it, of a frame with a state.
std::string FormatCovarianceRow(const FrameEstimate& frame);

/// What is in a states.csv.
struct StatesFile {
  PoseSeries states;                // without covariance
  PoseSeries closed_form;           // with the low-passed twist
  std::vector<StateVector> sigmas;  // one a state; empty where the file has no such columns
};

/// Reads states.csv: the state's columns are required, those of the closed form and of the standard
/// deviations are not. "out/states.csv:12: vx_world: expected a finite number, got 'x'".
Result<StatesFile> ReadStatesCsv(const std::string& path, const Limits& limits = {});

/// Sets the covariance of every pose that covariance.csv has a row of the same stamp for.
Status ReadCovarianceCsv(const std::string& path, PoseSeries* series, const Limits& limits = {});

}  // namespace tagtwist::internal
