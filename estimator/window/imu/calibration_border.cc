#include "estimator/window/imu/calibration_border.h"

#include <Eigen/Cholesky>
#include <map>
#include <memory>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"
#include "residuals/shifted_residual.h"

namespace tagtwist::internal {
namespace {

constexpr int kSize = kBlockSize;

// A factor's Jacobian by its blocks in one by whole states, from the first that it touches on.
Eigen::MatrixXd ByStates(const Factor& factor, const Eigen::MatrixXd& by_blocks) {
  const int first = factor.blocks.front().index, last = factor.blocks.back().index;
  Eigen::MatrixXd out = Eigen::MatrixXd::Zero(by_blocks.rows(), (last - first + 1) * kSize);
  Eigen::Index column = 0;
  for (const BlockRef& block : factor.blocks) {
    const int size = TangentSize(block.kind);
    const Eigen::Index at = static_cast<Eigen::Index>(block.index - first) * kSize +
                            (block.kind == BlockRef::Kind::kPose ? 0 : 6);
    out.middleCols(at, size) = by_blocks.middleCols(column, size);
    column += size;
  }
  return out;
}

}  // namespace

CalibrationBorder::CalibrationBorder(const CalibratedState& known, const GraphState& first)
    : reference_(known.calibration),
      root_(known.covariance.llt().matrixL()),
      first_(first),
      is_tied_(true) {
  const Block information = known.given_calibration.ldlt().solve(Block::Identity());
  cross_ = OfTangent(first, -information * known.by_calibration);
  own_ += known.by_calibration.transpose() * information * known.by_calibration;
}

// What is by a step of a state, by the prior's tangent at that state.
CalibrationBorder::OfState CalibrationBorder::OfTangent(const GraphState& state,
                                                        const OfState& by_step) {
  return DifferenceInWorldByStep(state, state, kTangent).transpose().partialPivLu().solve(by_step);
}

CalibrationBorder::OfState CalibrationBorder::CrossAt(const GraphState& first) const {
  return DifferenceInWorldByStep(first, first_, kTangent).transpose() * cross_;
}

ImuCalibration CalibrationBorder::calibration() const { return Retract(reference_, root_ * u_); }

ImuStepCovariance CalibrationBorder::covariance() const {
  return root_ * covariance_ * root_.transpose();
}

void CalibrationBorder::Restart() {
  is_tied_ = false;
  cross_.setZero();
  own_ = covariance_.llt().solve(ImuStepCovariance::Identity());
  gradient_.setZero();
  u_there_ = u_;
}

std::vector<CalibrationBorder::OfFactor> CalibrationBorder::Linearize(
    const QuadraticChain& chain) const {
  const Graph& graph = chain.graph();
  const ImuCalibration now = calibration();
  std::vector<OfFactor> out;
  LinearFactor linear;
  for (const Factor& factor : graph.factors) {
    if (factor.IsOnOnePose() || !LinearizeFactor(graph, factor, &linear)) continue;
    out.push_back({factor.cost.get(), factor.blocks.front().index,
                   ByCalibration(factor, linear.jacobian, graph, now) * root_, linear.residual,
                   ByStates(factor, linear.jacobian)});
  }
  return out;
}

CalibrationBorder::Entries CalibrationBorder::PriorGradient(const GraphState& first) const {
  Entries out = gradient_ + own_ * (u_ - u_there_);
  if (is_tied_) out += cross_.transpose() * DifferenceInWorld(first, first_, kTangent);
  return out;
}

bool CalibrationBorder::Update(QuadraticChain* chain, BlockBandedMatrix* covariance,
                               std::vector<GraphFrame>* states) {
  const std::vector<OfFactor> factors = Linearize(*chain);
  const LinearSystem system = chain->NormalEquations();
  const BlockBandedCholesky cholesky(system.hessian);
  if (!cholesky.ok()) return false;
  Columns cross = Columns::Zero(system.gradient.size(), kImuEntries);
  if (is_tied_) cross.topRows<kSize>() = CrossAt(chain->graph().states.front());
  ImuStepCovariance own = own_;
  Entries gradient = PriorGradient(chain->graph().states.front());
  for (const OfFactor& factor : factors) {
    cross.middleRows(static_cast<Eigen::Index>(factor.first) * kSize, factor.by_states.cols()) +=
        factor.by_states.transpose() * factor.by;
    own += factor.by.transpose() * factor.by;
    gradient += factor.by.transpose() * factor.residual;
  }
  Columns shifts(cross.rows(), kImuEntries);
  for (int i = 0; i < kImuEntries; ++i) shifts.col(i) = cholesky.Solve(cross.col(i));
  const Eigen::LLT<ImuStepCovariance> schur(own - cross.transpose() * shifts);
  if (schur.info() != Eigen::Success) return false;
  covariance_ = schur.solve(ImuStepCovariance::Identity());
  const Entries moved = -(covariance_ * (gradient - shifts.transpose() * system.gradient));
  const Eigen::VectorXd of_states = -(shifts * moved);
  const ImuStepCovariance root = covariance_.llt().matrixL();
  const Columns open = shifts * root;
  for (size_t k = 0; k < states->size(); ++k) {
    const auto row = static_cast<Eigen::Index>(k) * kSize;
    const auto of_state = open.middleRows<kSize>(row);
    covariance->At(static_cast<int>(k), static_cast<int>(k)) += of_state * of_state.transpose();
    GraphState state = chain->graph().states[k];
    state = Retract(state, of_states.segment<kSize>(row));
    (*states)[k].state = ToBodyState(state);
    (*states)[k].acceleration = ToAcceleration(state);
  }
  Follow(factors, moved, chain);
  u_ += moved;
  return true;
}

// The factors' residuals and the prior's gradient as of the calibration that has moved.
void CalibrationBorder::Follow(const std::vector<OfFactor>& factors, const Entries& moved,
                               QuadraticChain* chain) {
  std::map<const ceres::CostFunction*, const OfFactor*> of;
  for (const OfFactor& each : factors) of[each.cost] = &each;
  chain->ChangeFactors([&](const Graph&, Factor* factor) {
    const auto found = of.find(factor->cost.get());
    if (found == of.end()) return;
    Eigen::VectorXd shift = found->second->by * moved;
    if (const auto shifted = std::dynamic_pointer_cast<const ShiftedResidual>(factor->cost)) {
      shift += shifted->shift();
    }
    factor->cost = std::make_shared<ShiftedResidual>(AtFirst(*factor), std::move(shift));
    if (factor->kind == FactorKind::kMotion) factor->kind = FactorKind::kOther;  // of another cost
  });
  if (is_tied_) chain->ShiftPrior(cross_ * moved);
}

void CalibrationBorder::MarginalizeFirst(const QuadraticChain& chain) {
  const LinearSystem leaving = chain.Leaving();
  OfState of_first = OfState::Zero(), of_second = OfState::Zero();
  if (is_tied_) of_first = CrossAt(chain.graph().states.front());
  ImuStepCovariance own = own_;
  Entries gradient = PriorGradient(chain.graph().states.front());
  for (const OfFactor& factor : Linearize(chain)) {
    if (factor.first != 0) continue;
    of_first += factor.by_states.leftCols<kSize>().transpose() * factor.by;
    if (factor.by_states.cols() > kSize) {
      of_second += factor.by_states.rightCols<kSize>().transpose() * factor.by;
    }
    own += factor.by.transpose() * factor.by;
    gradient += factor.by.transpose() * factor.residual;
  }
  const Eigen::LDLT<Block> pivot(Block(leaving.hessian.At(0, 0).selfadjointView<Eigen::Lower>()));
  const OfState taken = pivot.solve(of_first);
  own_ = own - of_first.transpose() * taken;
  gradient_ = gradient - taken.transpose() * leaving.gradient.head<kSize>();
  u_there_ = u_;
  is_tied_ = leaving.hessian.size() > 1;
  cross_.setZero();
  if (!is_tied_) return;
  first_ = chain.graph().states[1];
  cross_ = OfTangent(first_, of_second - leaving.hessian.At(1, 0) * taken);
}

}  // namespace tagtwist::internal
