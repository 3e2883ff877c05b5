#include "estimator/imu/imu_border.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"
#include "frontend/types/so3.h"
#include "residuals/imu_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, 6>;

// For the derivatives [rad]: what it moves is far above rounding and below curvature.
constexpr double kStep = 1e-5;
constexpr size_t kClock = 2;  // entry of the error state, which has another derivative

ImuStep PriorSigmas(const ImuOptions& options) {
  // Gravity starts from a mean over the recording; an entry that is given moves by nothing.
  constexpr double kGravityRad = 0.3, kGiven = 1e-9;
  const double mount = std::max(kGiven, options.mount_sigma_rad);
  ImuStep out;
  out << kGravityRad, kGravityRad, std::max(kGiven, options.time_offset_sigma_s), mount, mount,
      mount;
  return out;
}

// How far the calibration is from the reference, in the error state; of gravity, which has a wide
// prior about where it is, nothing.
ImuStep FromReference(const ImuCalibration& calibration, const ImuCalibration& reference) {
  ImuStep out = ImuStep::Zero();
  out(2) = calibration.time_offset_s - reference.time_offset_s;
  out.tail<3>() = LogSo3(reference.body_from_imu.conjugate() * calibration.body_from_imu);
  return out;
}

Eigen::VectorXd ResidualOf(const Factor& factor, size_t frame, const Graph& graph) {
  std::vector<const double*> parameters;
  for (BlockRef block : factor.blocks) {
    block.index += static_cast<int>(frame);
    parameters.push_back(graph.Parameters(block));
  }
  Eigen::VectorXd out(factor.cost->num_residuals());
  factor.cost->Evaluate(parameters.data(), out.data(), nullptr);
  return out;
}

// The frames' factors under calibrations moved either way along each entry.
using Moved = std::array<std::array<std::vector<GraphFrame>, 2>, 6>;

Moved MoveCalibration(const ImuRecord& imu, const ImuModel& model,
                      const std::vector<GraphFrame>& frames) {
  Moved out;
  std::vector<GraphFrame> bare = frames;
  for (GraphFrame& frame : bare) frame.tags.clear();
  for (size_t i = 0; i < 6; ++i) {
    if (i == kClock) continue;
    for (size_t way = 0; way < 2; ++way) {
      out[i][way] = bare;
      ImuStep step = ImuStep::Zero();
      step(static_cast<Eigen::Index>(i)) = way == 0 ? kStep : -kStep;
      SetImuFactors(
          imu, {Retract(model.calibration, step), model.scale, model.of_motion, model.elsewhere},
          &out[i][way]);
    }
  }
  return out;
}

// The states around one, fewer at the ends: what their rates and velocities are off by comes from
// the IMU's own noise, and must not look like change.
std::pair<size_t, size_t> Around(const Graph& graph, size_t k, size_t reach) {
  return {k < reach ? 0 : k - reach, std::min(k + reach, graph.states.size() - 1)};
}

Eigen::Vector3d MeanRate(const Graph& graph, size_t k) {
  const auto [first, last] = Around(graph, k, 2);
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (size_t i = first; i <= last; ++i) sum += graph.states[i].rates.segment<3>(3);
  return sum / static_cast<double>(last - first + 1);
}

// What is felt at a state: its acceleration less gravity.
Eigen::Vector3d ForceAt(const Graph& graph, size_t k, const Eigen::Vector3d& gravity_world_mps2) {
  const auto [first, last] = Around(graph, k, 3);
  const GraphState &a = graph.states[first], &b = graph.states[last];
  const Eigen::Vector3d acceleration =
      (b.rates.head<3>() - a.rates.head<3>()) / ToSeconds(b.t_ns - a.t_ns);
  return graph.states[k].pose.rotation().conjugate() * (acceleration - gravity_world_mps2);
}

Eigen::VectorXd ByClock(const ImuResidual& residual, size_t frame, const Graph& graph,
                        const Eigen::Vector3d& gravity_world_mps2) {
  return residual.ByClock(MeanRate(graph, frame - 1), MeanRate(graph, frame),
                          ForceAt(graph, frame - 1, gravity_world_mps2),
                          ForceAt(graph, frame, gravity_world_mps2));
}

// A factor's derivative by the calibration; nullopt where the IMU covers the frame no longer.
std::optional<Columns> ByCalibration(const Moved& moved, size_t frame, size_t factor,
                                     const Graph& graph, Eigen::Index rows) {
  Columns out = Columns::Zero(rows, 6);
  for (size_t i = 0; i < 6; ++i) {
    if (i == kClock) continue;
    std::array<Eigen::VectorXd, 2> residuals;
    for (size_t way = 0; way < 2; ++way) {
      const std::vector<Factor>& others = moved[i][way][frame].others;
      if (factor >= others.size()) return std::nullopt;
      residuals[way] = ResidualOf(others[factor], frame, graph);
      if (residuals[way].size() != rows) return std::nullopt;
    }
    out.col(static_cast<Eigen::Index>(i)) = (residuals[0] - residuals[1]) / (2 * kStep);
  }
  return out;
}

// Normal equations of the calibration, beside those of the states.
struct Bordered {
  Columns cross;                                                          // J_states' J
  Eigen::Matrix<double, 6, 6> own = Eigen::Matrix<double, 6, 6>::Zero();  // J' J
  ImuStep gradient = ImuStep::Zero();
};

void AddFactorOf(size_t frame, const Factor& factor, const Columns& by, const Graph& graph,
                 Bordered* out) {
  Factor placed = factor;
  for (BlockRef& block : placed.blocks) block.index += static_cast<int>(frame);
  LinearFactor linear;
  if (!LinearizeFactor(graph, placed, &linear)) return;
  Eigen::Index column = 0;
  for (const BlockRef& block : placed.blocks) {
    const int size = TangentSize(block.kind);
    const Eigen::Index row = static_cast<Eigen::Index>(block.index) * kSize +
                             (block.kind == BlockRef::Kind::kPose ? 0 : 6);
    out->cross.middleRows(row, size) += linear.jacobian.middleCols(column, size).transpose() * by;
    column += size;
  }
  out->own += by.transpose() * by;
  out->gradient += by.transpose() * linear.residual;
}

}  // namespace

double ImuBorder::StepInSigmas() const {
  double out = 0;
  for (int i = 0; i < 6; ++i) {
    out = std::max(out, std::abs(step(i)) / std::sqrt(std::max(1e-30, covariance(i, i))));
  }
  return out;
}

std::optional<ImuBorder> MakeBorder(const ImuRecord& imu, const ImuModel& model,
                                    const ImuCalibration& reference,
                                    const std::vector<GraphFrame>& frames, const Graph& graph) {
  const LinearSystem system = Linearize(graph);
  const BlockBandedCholesky cholesky(system.hessian);
  if (!cholesky.ok()) return std::nullopt;
  const Moved moved = MoveCalibration(imu, model, frames);
  Bordered border;
  border.cross = Columns::Zero(kSize * static_cast<Eigen::Index>(frames.size()), 6);
  for (size_t k = 0; k < frames.size(); ++k) {
    const std::vector<Factor>& others = frames[k].others;
    for (size_t f = 0; f < others.size(); ++f) {
      // Of the gyro's rates at a frame the samples that they are from change as the clock moves,
      // and what a turn between frames says of it has them all.
      const auto* of_motion = dynamic_cast<const ImuResidual*>(others[f].cost.get());
      if (of_motion == nullptr) continue;
      auto by = ByCalibration(moved, k, f, graph, of_motion->num_residuals());
      if (!by) continue;
      by->col(kClock) = ByClock(*of_motion, k, graph, model.calibration.gravity_world_mps2);
      AddFactorOf(k, others[f], *by, graph, &border);
    }
  }
  const ImuStep weights = PriorSigmas(imu.options).array().square().inverse();
  border.own.diagonal() += weights;
  border.gradient += weights.cwiseProduct(FromReference(model.calibration, reference));
  Columns shifts(border.cross.rows(), 6);
  for (int i = 0; i < 6; ++i) shifts.col(i) = cholesky.Solve(border.cross.col(i));
  const Eigen::LLT<Eigen::Matrix<double, 6, 6>> schur(border.own -
                                                      border.cross.transpose() * shifts);
  if (schur.info() != Eigen::Success) return std::nullopt;
  ImuBorder out;
  out.covariance = schur.solve(Eigen::Matrix<double, 6, 6>::Identity());
  out.step = -(out.covariance * (border.gradient - shifts.transpose() * system.gradient));
  const Eigen::Matrix<double, 6, 6> root =
      Eigen::LLT<Eigen::Matrix<double, 6, 6>>(out.covariance).matrixL();
  for (int i = 0; i < 6; ++i) out.shared_errors.emplace_back(-shifts * root.col(i));
  return out;
}

}  // namespace tagtwist::internal
