#include "estimator/calibration_normals.h"

#include <Eigen/Cholesky>
#include <cmath>

#include "estimator/ground_truth.h"
#include "residuals/tag_calibration_residual.h"
#include "residuals/truth_residual.h"

namespace tagtwist {
namespace {

constexpr int kTruthColumns = 13;  // mount, world, clock

// Weight of a whitened block under the Huber loss, and the loss.
struct Robust {
  double weight = 1, cost = 0;
};
Robust Huber(double squared_norm, double dof, double scale) {
  const double delta = scale * std::sqrt(dof), norm = std::sqrt(squared_norm);
  if (norm <= delta) return {1, 0.5 * squared_norm};
  return {delta / norm, delta * (norm - 0.5 * delta)};
}

struct WhitenedTruth {
  Eigen::Matrix<double, 6, 1> residual;
  Eigen::Matrix<double, 6, 6> by_cam;
  Eigen::Matrix<double, 6, kTruthColumns> by_shared;
};

std::optional<WhitenedTruth> LinearizeTruth(const CalibrationProblem& problem,
                                            const CalibrationState& state,
                                            const CalibrationFrame& frame,
                                            const CalibrationNoise& noise) {
  const int64_t t_ns = frame.t_ns + std::llround(1e9 * state.time_offset_s);
  const auto truth = InterpolateTruth(problem.truth, t_ns, kMaxTruthGapS);
  if (!truth) return std::nullopt;
  const Twist rate = DifferentiateTruth(problem.truth, t_ns, kMaxTruthGapS).value_or(Twist());
  const TruthResidual at = EvaluateTruth(truth->world_from_body, rate, state.truth_from_world,
                                         frame.world_from_cam, state.cam_from_body);
  Eigen::Matrix<double, 6, 1> weights;
  weights.head<3>().setConstant(
      1 / (noise.truth_rotation_sigma_rad * noise.truth_rotation_persistence));
  weights.tail<3>().setConstant(1 /
                                (noise.truth_position_sigma_m * noise.truth_position_persistence));
  WhitenedTruth out;
  out.residual = weights.asDiagonal() * at.residual;
  out.by_cam = weights.asDiagonal() * at.by_cam;
  out.by_shared << at.by_mount, at.by_world, at.by_offset;
  out.by_shared = weights.asDiagonal() * out.by_shared;
  return out;
}

// Normal equations of one frame: its pose (f) and its shared columns (s).
struct FrameNormals {
  Eigen::Matrix<double, 6, 6> ff = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, Eigen::Dynamic> fs;
  Eigen::MatrixXd ss;
  Eigen::Matrix<double, 6, 1> f = Eigen::Matrix<double, 6, 1>::Zero();
  Eigen::VectorXd s;
  std::vector<int> columns;  // those before the tags come first
};

FrameNormals EmptyNormals(const CalibrationLayout& layout, const CalibrationFrame& frame,
                          bool shared) {
  FrameNormals out;
  for (int i = 0; shared && i < layout.tag(0); ++i) out.columns.push_back(i);
  for (const CalibrationView& view : frame.views) {
    for (int i = 0; shared && i < 6; ++i) out.columns.push_back(layout.tag(view.tag) + i);
  }
  const auto n = static_cast<Eigen::Index>(out.columns.size());
  out.fs.setZero(6, n);
  out.ss.setZero(n, n);
  out.s.setZero(n);
  return out;
}

// Adds a view; `first` is its tag's first column.
void AddView(const TagCalibrationResidual& at, double weight, Eigen::Index first,
             FrameNormals* out) {
  out->ff.noalias() += weight * at.by_cam.transpose() * at.by_cam;
  out->f.noalias() += weight * at.by_cam.transpose() * at.residual;
  if (out->columns.empty()) return;
  const Eigen::Index n_lens = at.by_lens.cols(), n = n_lens + 1;
  Eigen::Matrix<double, 8, Eigen::Dynamic> by_global(8, n);
  by_global << at.by_lens, at.by_log_scale;
  out->fs.leftCols(n).noalias() += weight * at.by_cam.transpose() * by_global;
  out->fs.middleCols<6>(first).noalias() += weight * at.by_cam.transpose() * at.by_tag;
  out->ss.topLeftCorner(n, n).noalias() += weight * by_global.transpose() * by_global;
  const Eigen::MatrixXd cross = weight * at.by_tag.transpose() * by_global;
  out->ss.block(first, 0, 6, n) += cross;
  out->ss.block(0, first, n, 6) += cross.transpose();
  out->ss.block<6, 6>(first, first).noalias() += weight * at.by_tag.transpose() * at.by_tag;
  out->s.head(n).noalias() += weight * by_global.transpose() * at.residual;
  out->s.segment<6>(first).noalias() += weight * at.by_tag.transpose() * at.residual;
}

void AddTruth(const WhitenedTruth& at, double weight, Eigen::Index first, FrameNormals* out) {
  out->ff.noalias() += weight * at.by_cam.transpose() * at.by_cam;
  out->f.noalias() += weight * at.by_cam.transpose() * at.residual;
  if (out->columns.empty()) return;
  out->fs.middleCols<kTruthColumns>(first).noalias() +=
      weight * at.by_cam.transpose() * at.by_shared;
  out->ss.block<kTruthColumns, kTruthColumns>(first, first).noalias() +=
      weight * at.by_shared.transpose() * at.by_shared;
  out->s.segment<kTruthColumns>(first).noalias() += weight * at.by_shared.transpose() * at.residual;
}

// Eliminates the pose and adds what is left to the shared normal equations.
EliminatedFrame Eliminate(const FrameNormals& at, double damping, CalibrationNormals* out) {
  Eigen::Matrix<double, 6, 6> ff = at.ff;
  ff.diagonal() *= 1 + damping;
  ff.diagonal().array() += 1e-9;  // of a pose that its tags leave open
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> llt(ff);
  EliminatedFrame frame;
  frame.columns = at.columns;
  frame.offset = llt.solve(at.f);
  frame.covariance = llt.solve(Eigen::Matrix<double, 6, 6>::Identity());
  frame.by_shared.resize(6, 0);
  if (at.columns.empty())
    return frame;  // Eigen solves nothing for nothing by way of a null pointer
  frame.by_shared = llt.solve(at.fs);
  Eigen::MatrixXd left = at.ss;
  left.noalias() -= at.fs.transpose() * frame.by_shared;
  const Eigen::VectorXd gradient = at.s - at.fs.transpose() * frame.offset;
  for (size_t j = 0; j < at.columns.size(); ++j) {
    const auto column = static_cast<Eigen::Index>(j);
    out->gradient(at.columns[j]) += gradient(column);
    double* const into = out->information.col(at.columns[j]).data();
    for (size_t i = 0; i < at.columns.size(); ++i) {
      into[at.columns[i]] += left(static_cast<Eigen::Index>(i), column);
    }
  }
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
  const double scale = std::exp(state.log_scale);
  const bool shared = problem.prior_sigmas.maxCoeff() > 0;
  TagCalibrationResidual at;
  for (const CalibrationFrame& frame : frames) {
    FrameNormals normals = EmptyNormals(layout, frame, shared);
    Eigen::Index first = layout.tag(0);
    for (const CalibrationView& view : frame.views) {
      const Tag& tag = state.tags[static_cast<size_t>(view.tag)];
      if (!EvaluateTagCalibration(tag, scale, state.camera, frame.world_from_cam, view.pixels,
                                  view.whitener, &at, shared)) {
        return out;
      }
      const Robust robust = Huber(at.residual.squaredNorm(), 8, problem.robust_scale);
      out.cost += robust.cost;
      AddView(at, robust.weight, first, &normals);
      first += 6;
    }
    if (frame.has_truth) {
      const auto truth = LinearizeTruth(problem, state, frame, noise);
      if (!truth) return out;
      const Robust robust = Huber(truth->residual.squaredNorm(), 6, problem.robust_scale);
      out.cost += robust.cost;
      AddTruth(*truth, robust.weight, layout.mount(), &normals);
    }
    out.frames.push_back(Eliminate(normals, damping, &out));
  }
  AddPrior(problem, state, &out);
  out.ok = std::isfinite(out.cost);
  return out;
}

std::optional<double> FrameCost(const CalibrationProblem& problem, const CalibrationState& state,
                                const CalibrationFrame& frame, const CalibrationNoise& noise) {
  double cost = 0;
  TagCalibrationResidual at;
  for (const CalibrationView& view : frame.views) {
    if (!EvaluateTagCalibration(state.tags[static_cast<size_t>(view.tag)],
                                std::exp(state.log_scale), state.camera, frame.world_from_cam,
                                view.pixels, view.whitener, &at, false)) {
      return std::nullopt;
    }
    cost += Huber(at.residual.squaredNorm(), 8, problem.robust_scale).cost;
  }
  if (!frame.has_truth) return cost;
  const auto truth = LinearizeTruth(problem, state, frame, noise);
  if (!truth) return std::nullopt;
  return cost + Huber(truth->residual.squaredNorm(), 6, problem.robust_scale).cost;
}

namespace {

// Correlation of successive errors, from their sums.
class Succession {
 public:
  void Add(const Eigen::Vector3d& error) {
    squares_ += error.squaredNorm();
    products_ += error.dot(last_);
    last_ = error;
  }
  double Correlation() const { return squares_ > 0 ? products_ / squares_ : 0; }

 private:
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
  double squares_ = 0, products_ = 0;
};

}  // namespace

NoiseSums SumNoise(const CalibrationProblem& problem, const CalibrationState& state,
                   const std::vector<CalibrationFrame>& frames, const CalibrationNoise& noise,
                   const CalibrationNormals& normals, const Eigen::MatrixXd& covariance) {
  NoiseSums out;
  double all = 0;
  Succession rotation, position;
  const CalibrationLayout layout = LayoutOf(state);
  TagCalibrationResidual at;
  for (size_t i = 0; i < frames.size(); ++i) {
    const EliminatedFrame& eliminated = normals.frames[i];
    for (const CalibrationView& view : frames[i].views) {
      if (!EvaluateTagCalibration(state.tags[static_cast<size_t>(view.tag)],
                                  std::exp(state.log_scale), state.camera, frames[i].world_from_cam,
                                  view.pixels, view.whitener, &at, false)) {
        continue;
      }
      const double squared = at.residual.squaredNorm();
      out.corner += Huber(squared, 8, problem.robust_scale).weight * squared;
      all += 8;
    }
    all -= 6;
    if (!frames[i].has_truth) continue;
    const auto truth = LinearizeTruth(problem, state, frames[i], noise);
    if (!truth) continue;
    const double weight = Huber(truth->residual.squaredNorm(), 6, problem.robust_scale).weight;
    rotation.Add(std::sqrt(weight) * truth->residual.head<3>());
    position.Add(std::sqrt(weight) * truth->residual.tail<3>());
    ++out.truth_frames;
    out.truth_rotation += weight * truth->residual.head<3>().squaredNorm();
    out.truth_position += weight * truth->residual.tail<3>().squaredNorm();
    // Of the whitened residual's prediction: by the pose alone, and by the shared parameters, which
    // move the pose, too.
    Eigen::Matrix<double, 6, 1> taken =
        (truth->by_cam * eliminated.covariance * truth->by_cam.transpose()).diagonal();
    if (!eliminated.columns.empty()) {
      Eigen::Matrix<double, 6, Eigen::Dynamic> by_shared = -truth->by_cam * eliminated.by_shared;
      by_shared.middleCols<kTruthColumns>(layout.mount()) += truth->by_shared;
      const Eigen::MatrixXd shared = covariance(eliminated.columns, eliminated.columns);
      taken += (by_shared * shared * by_shared.transpose()).diagonal();
    }
    const Eigen::Matrix<double, 6, 1> redundancy =
        Eigen::Matrix<double, 6, 1>::Ones() - weight * taken;
    out.truth_rotation_redundancy += redundancy.head<3>().sum();
    out.truth_position_redundancy += redundancy.tail<3>().sum();
    all += 6;
  }
  for (Eigen::Index i = 0; i < problem.prior_sigmas.size(); ++i) {
    const double sigma = problem.prior_sigmas(i);
    if (sigma > 0) all -= 1 - covariance(i, i) / (sigma * sigma);
  }
  out.truth_position_correlation = position.Correlation();
  out.truth_rotation_correlation = rotation.Correlation();
  out.corner_redundancy = all - out.truth_position_redundancy - out.truth_rotation_redundancy;
  return out;
}

}  // namespace tagtwist
