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
#include "residuals/shifted_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;
using Columns = Eigen::Matrix<double, Eigen::Dynamic, kImuEntries>;
constexpr int kClock = 2;  // entry of the error state

ImuStep PriorSigmas(const ImuOptions& options) {
  // Gravity starts from a mean over the recording; an entry that is given moves by nothing.
  constexpr double kGravityRad = 0.3, kGiven = 1e-9;
  const double turn = std::max(kGiven, options.mount_sigma_rad),
               place = std::max(kGiven, options.mount_sigma_m);
  ImuStep out;
  out << kGravityRad, kGravityRad, std::max(kGiven, options.time_offset_sigma_s), turn, turn, turn,
      place, place, place;
  return out;
}

// How far the calibration is from the reference, in the error state; of gravity, which has a wide
// prior about where it is, nothing.
ImuStep FromReference(const ImuCalibration& calibration, const ImuCalibration& reference) {
  ImuStep out = ImuStep::Zero();
  out(2) = calibration.time_offset_s - reference.time_offset_s;
  out.tail<6>() = Difference(calibration.body_from_imu, reference.body_from_imu);
  return out;
}

// How a state changes in a second, from those around it, fewer at the ends; the biases do not.
GraphStep RateOf(const Graph& graph, size_t k) {
  constexpr size_t kReach = 2;
  const size_t first = k < kReach ? 0 : k - kReach,
               last = std::min(k + kReach, graph.states.size() - 1);
  const GraphState &a = graph.states[first], &b = graph.states[last];
  GraphStep out = GraphStep::Zero();
  out.head<3>() = graph.states[k].rates.segment<3>(3);
  out.segment<3>(3) = graph.states[k].rates.head<3>();
  if (last > first) {
    out.segment<6>(6) = (b.rates.head<6>() - a.rates.head<6>()) / ToSeconds(b.t_ns - a.t_ns);
  }
  return out;
}

// Normal equations of the calibration, beside those of the states.
struct Bordered {
  Columns cross;                                      // J_states' J
  ImuStepCovariance own = ImuStepCovariance::Zero();  // J' J
  ImuStep gradient = ImuStep::Zero();
};

void AddFactor(const Factor& factor, const LinearFactor& linear, const Columns& by, Bordered* out) {
  Eigen::Index column = 0;
  for (const BlockRef& block : factor.blocks) {
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

Eigen::MatrixXd ByCalibration(const Factor& factor, const Eigen::MatrixXd& by_states,
                              const Graph& graph, const ImuCalibration& calibration) {
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(by_states.rows(), kImuEntries);
  Eigen::Index column = 0;
  for (const BlockRef& block : factor.blocks) {
    const int size = TangentSize(block.kind);
    const Eigen::Index entry = block.kind == BlockRef::Kind::kPose ? 0 : 6;
    out.col(kClock) -= by_states.middleCols(column, size) *
                       RateOf(graph, static_cast<size_t>(block.index)).segment(entry, size);
    column += size;
  }
  const auto cost = AtFirst(factor);
  const auto* const residual = dynamic_cast<const ImuResidual*>(cost.get());
  if (residual == nullptr) return out;
  std::array<const double*, 4> parameters{};
  for (size_t i = 0; i < 4; ++i) parameters[i] = graph.Parameters(factor.blocks[i]);
  out.leftCols<2>() = residual->ByGravity(parameters.data()) * ByTurns(calibration);
  out.middleCols<3>(3) =
      residual->ByAxes() * calibration.body_from_imu.rotation().toRotationMatrix();
  out.rightCols<3>() = residual->ByPlace(parameters.data());
  return out;
}

std::shared_ptr<const ceres::CostFunction> AtFirst(const Factor& factor) {
  const auto shifted = std::dynamic_pointer_cast<const ShiftedResidual>(factor.cost);
  return shifted ? shifted->at_first() : factor.cost;
}

double ImuBorder::StepInSigmas() const {
  double out = 0;
  for (int i = 0; i < kImuEntries; ++i) {
    out = std::max(out, std::abs(step(i)) / std::sqrt(std::max(1e-30, covariance(i, i))));
  }
  return out;
}

std::optional<ImuBorder> MakeBorder(const ImuOptions& options, const ImuModel& model,
                                    const ImuCalibration& reference, const Graph& graph) {
  const LinearSystem system = Linearize(graph);
  const BlockBandedCholesky cholesky(system.hessian);
  if (!cholesky.ok()) return std::nullopt;
  Bordered border;
  border.cross = Columns::Zero(kSize * static_cast<Eigen::Index>(graph.states.size()), kImuEntries);
  LinearFactor linear;
  for (const Factor& factor : graph.factors) {
    if (factor.IsOnOnePose() || !LinearizeFactor(graph, factor, &linear)) continue;
    AddFactor(factor, linear, ByCalibration(factor, linear.jacobian, graph, model.calibration),
              &border);
  }
  const ImuStep weights = PriorSigmas(options).array().square().inverse();
  border.own.diagonal() += weights;
  border.gradient += weights.cwiseProduct(FromReference(model.calibration, reference));
  Columns shifts(border.cross.rows(), kImuEntries);
  for (int i = 0; i < kImuEntries; ++i) shifts.col(i) = cholesky.Solve(border.cross.col(i));
  const Eigen::LLT<ImuStepCovariance> schur(border.own - border.cross.transpose() * shifts);
  if (schur.info() != Eigen::Success) return std::nullopt;
  ImuBorder out;
  out.covariance = schur.solve(ImuStepCovariance::Identity());
  out.step = -(out.covariance * (border.gradient - shifts.transpose() * system.gradient));
  const ImuStepCovariance root = Eigen::LLT<ImuStepCovariance>(out.covariance).matrixL();
  for (int i = 0; i < kImuEntries; ++i) out.shared_errors.emplace_back(-shifts * root.col(i));
  return out;
}

}  // namespace tagtwist::internal
