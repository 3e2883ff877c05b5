#include "estimator/calibration/normals.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/calibration/costs.h"
#include "frontend/base/statistics/robust.h"

namespace tagtwist::internal {
namespace {

constexpr int kMaxGlobals = kMaxLensSize + 2 + kTruthColumns;  // all but the tags' entries

using Matrix6 = Eigen::Matrix<double, 6, 6>;
using TagRows = Eigen::Matrix<double, kTagEntries, 6>;

// Which entries a frame depends on: the first `globals` ones, and those of its tags.
struct FrameColumns {
  Eigen::Index globals = 0;
  std::vector<int> tags;  // first entry of each view's tag; empty when all are held

  Eigen::Index size() const { return First(tags.size()); }
  // Of the entries of that view's tag among the frame's.
  Eigen::Index First(size_t view) const {
    return globals + kTagEntries * static_cast<Eigen::Index>(view);
  }
};

FrameColumns ColumnsOf(const CalibrationLayout& layout, const CalibrationFrame& frame,
                       bool free_tags) {
  FrameColumns out;
  out.globals = frame.has_truth ? layout.tag(0) : layout.mount();
  if (!free_tags) return out;
  for (const CalibrationView& view : frame.views()) out.tags.push_back(layout.tag(view.tag));
  return out;
}

// Adds a view to the shared normal equations, and to the frame's own: by the pose, and between the
// pose and the columns. `view`: its place among the frame's.
void AddView(const TagCalibrationResidual& at, double weight, const FrameColumns& columns,
             size_t view, CalibrationNormals* out, QuadraticForm<6>* pose,
             Eigen::Matrix<double, 6, Eigen::Dynamic>* by_columns) {
  const Eigen::Matrix<double, 6, 8> cam = weight * at.by_cam.transpose();
  pose->hessian += cam.lazyProduct(at.by_cam);
  pose->gradient += cam.lazyProduct(at.residual);
  const Eigen::Index n = at.by_lens.cols() + 2;
  Eigen::Matrix<double, 8, Eigen::Dynamic, Eigen::ColMajor, 8, kMaxGlobals> by_global(8, n);
  by_global << at.by_lens, at.by_log_scale, at.by_line_time;
  by_columns->leftCols(n) += cam.lazyProduct(by_global);
  const Eigen::Matrix<double, Eigen::Dynamic, 8, Eigen::ColMajor, kMaxGlobals, 8> weighted_global =
      weight * by_global.transpose();
  out->information.topLeftCorner(n, n) += weighted_global.lazyProduct(by_global);
  out->gradient.head(n) += weighted_global.lazyProduct(at.residual);
  if (columns.tags.empty()) return;
  const Eigen::Index local = columns.First(view);
  const int tag = columns.tags[view];
  by_columns->middleCols<kTagEntries>(local) += cam.lazyProduct(at.by_tag);
  const Eigen::Matrix<double, kTagEntries, 8> weighted_tag = weight * at.by_tag.transpose();
  out->information.block(tag, 0, kTagEntries, n) += weighted_tag.lazyProduct(by_global);
  out->information.block<kTagEntries, kTagEntries>(tag, tag) += weighted_tag.lazyProduct(at.by_tag);
  out->gradient.segment<kTagEntries>(tag) += weighted_tag.lazyProduct(at.residual);
}

void AddTruth(const WhitenedTruth& at, double weight, Eigen::Index first, CalibrationNormals* out,
              QuadraticForm<6>* pose, Eigen::Matrix<double, 6, Eigen::Dynamic>* by_columns) {
  const Matrix6 cam = weight * at.by_cam.transpose();
  pose->hessian += cam.lazyProduct(at.by_cam);
  pose->gradient += cam.lazyProduct(at.residual);
  by_columns->middleCols<kTruthColumns>(first) += cam.lazyProduct(at.by_shared);
  const Eigen::Matrix<double, kTruthColumns, 6> shared = weight * at.by_shared.transpose();
  out->information.block<kTruthColumns, kTruthColumns>(first, first) +=
      shared.lazyProduct(at.by_shared);
  out->gradient.segment<kTruthColumns>(first) += shared.lazyProduct(at.residual);
}

// Takes what the pose explains from the lower triangle of the shared normal equations; `half` is
// L^-1 by_columns, L L' the pose's information.
void Subtract(const Eigen::Matrix<double, 6, Eigen::Dynamic>& half,
              const Eigen::Matrix<double, 6, 1>& half_gradient, const FrameColumns& columns,
              CalibrationNormals* out) {
  const Eigen::Index n = columns.globals;
  const Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxGlobals> globals =
      half.leftCols(n);
  out->information.topLeftCorner(n, n) -= globals.transpose().lazyProduct(globals);
  out->gradient.head(n) -= globals.transpose().lazyProduct(half_gradient);
  for (size_t i = 0; i < columns.tags.size(); ++i) {
    const int row = columns.tags[i];
    const TagRows of_row = half.middleCols<kTagEntries>(columns.First(i)).transpose();
    out->gradient.segment<kTagEntries>(row) -= of_row.lazyProduct(half_gradient);
    out->information.block(row, 0, kTagEntries, n) -= of_row.lazyProduct(globals);
    for (size_t j = 0; j < columns.tags.size(); ++j) {
      const int column = columns.tags[j];
      if (column > row) continue;
      out->information.block<kTagEntries, kTagEntries>(row, column) -=
          of_row.lazyProduct(half.middleCols<kTagEntries>(columns.First(j)));
    }
  }
}

std::vector<int> EntriesOf(const FrameColumns& columns) {
  std::vector<int> out;
  for (int i = 0; i < columns.globals; ++i) out.push_back(i);
  for (const int first : columns.tags) {
    for (int i = 0; i < kTagEntries; ++i) out.push_back(first + i);
  }
  return out;
}

// A pose that is known stays where it is.
EliminatedFrame Keep(const FrameColumns& columns) {
  EliminatedFrame frame;
  frame.columns = EntriesOf(columns);
  frame.by_shared.setZero(6, columns.size());
  frame.offset.setZero();
  frame.covariance.setZero();
  return frame;
}

// Eliminates the pose.
EliminatedFrame Eliminate(QuadraticForm<6> pose,
                          const Eigen::Matrix<double, 6, Eigen::Dynamic>& by_all,
                          const FrameColumns& columns, double damping, CalibrationNormals* out) {
  pose.hessian.diagonal() *= 1 + damping;
  pose.hessian.diagonal().array() += kPoseRidge;
  const Eigen::LLT<Matrix6> llt(pose.hessian);
  EliminatedFrame frame;
  frame.offset = llt.solve(pose.gradient);
  frame.covariance = llt.solve(Matrix6::Identity());
  frame.by_shared = by_all;
  for (Eigen::Index j = 0; j < by_all.cols(); ++j) {
    Eigen::Matrix<double, 6, 1> column = frame.by_shared.col(j);
    llt.matrixL().solveInPlace(column);
    frame.by_shared.col(j) = column;
  }
  const Eigen::Matrix<double, 6, 1> half_gradient = llt.matrixL().solve(pose.gradient);
  Subtract(frame.by_shared, half_gradient, columns, out);
  for (Eigen::Index j = 0; j < by_all.cols(); ++j) {
    Eigen::Matrix<double, 6, 1> column = frame.by_shared.col(j);
    llt.matrixU().solveInPlace(column);
    frame.by_shared.col(j) = column;
  }
  frame.columns = EntriesOf(columns);
  out->pose_gain += 0.5 * half_gradient.squaredNorm();
  return frame;
}

void AddPrior(const CalibrationProblem& problem, const CalibrationState& state,
              CalibrationNormals* out) {
  const Eigen::VectorXd difference = Difference(state, problem.prior);
  for (Eigen::Index i = 0; i < difference.size(); ++i) {
    const double sigma = problem.prior_sigmas(i);
    if (!(sigma > 0)) continue;
    const double information = 1 / (sigma * sigma);
    out->information(i, i) += information;
    out->gradient(i) += information * difference(i);
    out->cost += 0.5 * information * difference(i) * difference(i);
  }
}

}  // namespace

CalibrationNormals LinearizeCalibration(const CalibrationProblem& problem,
                                        const CalibrationState& state,
                                        const std::vector<CalibrationFrame>& frames,
                                        const CalibrationNoise& noise, double damping) {
  const CalibrationLayout layout = LayoutOf(state);
  CalibrationNormals out;
  out.information.setZero(layout.size(), layout.size());
  out.gradient.setZero(layout.size());
  out.frames.reserve(frames.size());
  const bool free_tags = (problem.prior_sigmas.tail(kTagEntries * layout.n_tags).array() > 0).any();
  TagCalibrationResidual at;
  Eigen::Matrix<double, 6, Eigen::Dynamic> by_columns;
  for (const CalibrationFrame& frame : frames) {
    const FrameColumns columns = ColumnsOf(layout, frame, free_tags);
    QuadraticForm<6> pose;
    by_columns.setZero(6, columns.size());
    size_t k = 0;
    for (const CalibrationView& view : frame.views()) {
      if (!LinearizeView(state, frame, view, &at, true)) return out;
      const RobustLoss loss = Huber(at.residual.squaredNorm(), HuberDelta(problem.robust_scale, 8));
      out.cost += loss.cost;
      AddView(at, loss.weight, columns, k++, &out, &pose, &by_columns);
    }
    if (frame.has_truth) {
      const auto truth = LinearizeTruth(problem, state, frame, noise);
      if (!truth) return out;
      const RobustLoss loss =
          Huber(truth->residual.squaredNorm(), HuberDelta(problem.robust_scale, 6));
      out.cost += loss.cost;
      AddTruth(*truth, loss.weight, layout.mount(), &out, &pose, &by_columns);
    }
    out.frames.push_back(frame.pose_known ? Keep(columns)
                                          : Eliminate(pose, by_columns, columns, damping, &out));
  }
  AddPrior(problem, state, &out);
  out.information.triangularView<Eigen::StrictlyUpper>() = out.information.transpose();
  out.ok = std::isfinite(out.cost);
  return out;
}

}  // namespace tagtwist::internal
