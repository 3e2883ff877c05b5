#include "bench/scores.h"

#include <Eigen/Cholesky>
#include <array>
#include <cmath>

#include "estimator/batch/batch.h"
#include "estimator/window/sliding_window.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/chi_square.h"

namespace tagtwist::internal {
namespace {

StateVector ErrorOf(const FrameEstimate& estimate, const TruthSample& truth) {
  return Difference(estimate.state, {truth.world_from_body, *truth.twist});
}

double Nees(const StateCovariance& covariance, const StateVector& error, int first, int size) {
  const Eigen::VectorXd e = error.segment(first, size);
  const Eigen::MatrixXd p = covariance.block(first, first, size, size);
  return e.dot(p.llt().solve(e));
}

// Squared norms or traces of the four parts, in the order of Score.
Eigen::Vector4d Parts(const StateVector& squares) {
  return {squares.segment<3>(3).sum(), squares.head<3>().sum(), squares.segment<3>(6).sum(),
          squares.tail<3>().sum()};
}

// Frames `first` and later; those without a state are left out.
Score ScoreFrames(const std::vector<FrameEstimate>& frames, const std::vector<TruthSample>& truth,
                  size_t first) {
  Score out;
  out.runs = 1;
  for (size_t i = first; i < frames.size(); ++i) {
    if (frames[i].status == FrameStatus::kNoFix) continue;
    const StateCovariance& p = frames[i].covariance;
    const StateVector e = ErrorOf(frames[i], truth[i]);
    ++out.frames;
    out.squared_error += Parts(e.cwiseAbs2());
    out.squared_bound += Parts(p.diagonal());
    out.nees_pose += Nees(p, e, 0, 6);
    out.nees_twist += Nees(p, e, 6, 6);
  }
  const size_t middle = frames.size() / 2;
  out.nees_of_middle =
      Nees(frames[middle].covariance, ErrorOf(frames[middle], truth[middle]), 0, 12);
  return out;
}

std::array<double, 4> Ratios(const Score& score) {
  const Eigen::Vector4d r = (score.squared_error.cwiseQuotient(score.squared_bound)).cwiseSqrt();
  return {r(0), r(1), r(2), r(3)};
}

}  // namespace

Score& Score::operator+=(const Score& other) {
  runs += other.runs;
  frames += other.frames;
  squared_error += other.squared_error;
  squared_bound += other.squared_bound;
  nees_pose += other.nees_pose;
  nees_twist += other.nees_twist;
  nees_of_middle += other.nees_of_middle;
  return *this;
}

RunScores& RunScores::operator+=(const RunScores& other) {
  batch += other.batch;
  lagged += other.lagged;
  current += other.current;
  return *this;
}

Result<RunScores> ScoreRun(const SetUp& set_up, const EstimatorOptions& options,
                           const BenchRun& run) {
  const auto batch = RunBatch(set_up, options, run.measurements);
  if (!batch) return batch.error();
  std::vector<FrameEstimate> current, lagged;
  SlidingWindow window(set_up, options);
  for (const FrameMeasurements& m : run.measurements) {
    auto output = window.Add(m);
    if (!output) return output.error();
    for (FrameEstimate& left : output->lagged) lagged.push_back(std::move(left));
    current.push_back(std::move(output->current));
  }
  for (FrameEstimate& frame : window.Finish()) lagged.push_back(std::move(frame));
  if (lagged.size() != current.size()) return Error{"the window lost its last frames"};
  const auto filled = static_cast<size_t>(options.window_frames);
  return RunScores{ScoreFrames(batch->frames, run.truth, 0), ScoreFrames(lagged, run.truth, filled),
                   ScoreFrames(current, run.truth, filled)};
}

std::vector<std::string> ScoreHeader() {
  return {"flight",     "method", "runs", "pos mm", "att deg",       "vel m/s", "rate rad/s",
          "RMSE/bound", "",       "",     "",       "NEES/dof pose", "twist"};
}

std::vector<std::string> ScoreCells(const std::string& flight, const std::string& method,
                                    const Score& score) {
  const auto n = static_cast<double>(score.frames);
  const Eigen::Vector4d rmse = (score.squared_error / n).cwiseSqrt();
  std::vector<std::string> out = {flight,
                                  method,
                                  std::to_string(score.runs),
                                  Format("%.3f", 1e3 * rmse(0)),
                                  Format("%.4f", 57.29577951308232 * rmse(1)),
                                  Format("%.4f", rmse(2)),
                                  Format("%.4f", rmse(3))};
  for (const double ratio : Ratios(score)) out.push_back(Format("%.2f", ratio));
  out.push_back(Format("%.2f", score.nees_pose / (6 * n)));
  out.push_back(Format("%.2f", score.nees_twist / (6 * n)));
  return out;
}

std::string Verdict(const Score& score) {
  const double nees = score.nees_of_middle / static_cast<double>(score.runs);
  const ChiSquareBand band = MeanChiSquareBand(12, score.runs, 0.99);
  double worst = 0;
  for (const double ratio : Ratios(score)) worst = std::max(worst, ratio);
  return Format(
      "NEES %.2f over %zu runs, %s the 99 %% band %.2f to %.2f; RMSE / bound at most %.3f", nees,
      score.runs, nees >= band.low && nees <= band.high ? "inside" : "OUTSIDE", band.low, band.high,
      worst);
}

}  // namespace tagtwist::internal
