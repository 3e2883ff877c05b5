#include "estimator/graph/marginalisation.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <utility>
#include <vector>

#include "estimator/graph/linear_system.h"
#include "residuals/prior_residual.h"

namespace tagtwist::internal {
namespace {

// Blocks other than those of state 0 and points that the used factors touch, in order.
std::vector<BlockRef> RemainingBlocks(const Graph& graph, const std::vector<bool>& use) {
  std::vector<std::pair<int, int>> found;  // state, 0 pose or 1 rates
  for (size_t f = 0; f < graph.factors.size(); ++f) {
    if (!use[f]) continue;
    for (const BlockRef& block : graph.factors[f].blocks) {
      if (block.kind == BlockRef::Kind::kPoint || block.index == 0) continue;
      found.emplace_back(block.index, block.kind == BlockRef::Kind::kRates ? 1 : 0);
    }
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<BlockRef> blocks;
  for (const auto& [state, is_rates] : found) {
    blocks.push_back({is_rates == 1 ? BlockRef::Kind::kRates : BlockRef::Kind::kPose, state});
  }
  return blocks;
}

int Row(const BlockRef& block) {
  return kBlockSize * block.index + (block.kind == BlockRef::Kind::kRates ? 6 : 0);
}

// Normal equations of the remaining blocks after the Schur complement over state 0.
using Marginal = QuadraticForm<Eigen::Dynamic>;

Marginal SchurComplement(const LinearSystem& system, const std::vector<BlockRef>& blocks) {
  Eigen::Index size = 0;
  for (const BlockRef& block : blocks) size += TangentSize(block.kind);
  Marginal m{{}, Eigen::MatrixXd(size, size), Eigen::VectorXd(size), 0};
  Eigen::MatrixXd cross(kBlockSize, size);  // H(state 0, blocks)
  const auto block_at = [&](const BlockRef& a, const BlockRef& b) -> Eigen::MatrixXd {
    const int rows = TangentSize(a.kind), columns = TangentSize(b.kind);
    if (a.index - b.index > system.hessian.bandwidth()) return Eigen::MatrixXd::Zero(rows, columns);
    return system.hessian.At(a.index, b.index)
        .block(Row(a) % kBlockSize, Row(b) % kBlockSize, rows, columns);
  };
  Eigen::Index row = 0;
  for (size_t i = 0; i < blocks.size(); ++i) {
    const int rows = TangentSize(blocks[i].kind);
    m.gradient.segment(row, rows) = system.gradient.segment(Row(blocks[i]), rows);
    cross.block(0, row, 6, rows) = block_at(blocks[i], {BlockRef::Kind::kPose, 0}).transpose();
    cross.block(6, row, 12, rows) = block_at(blocks[i], {BlockRef::Kind::kRates, 0}).transpose();
    Eigen::Index column = 0;
    for (size_t j = 0; j <= i; ++j) {
      const int columns = TangentSize(blocks[j].kind);
      const Eigen::MatrixXd block = block_at(blocks[i], blocks[j]);
      m.hessian.block(row, column, rows, columns) = block;
      m.hessian.block(column, row, columns, rows) = block.transpose();
      column += columns;
    }
    row += rows;
  }
  const Eigen::LDLT<BlockBandedMatrix::Block> leaving(
      system.hessian.At(0, 0).selfadjointView<Eigen::Lower>());
  m.hessian.noalias() -= cross.transpose() * leaving.solve(cross);
  m.gradient.noalias() -= cross.transpose() * leaving.solve(system.gradient.head<kBlockSize>());
  return m;
}

// r = A d + b with A'A = hessian and A'b = gradient; directions without information are left out.
Factor MakePriorFactor(const Graph& graph, const std::vector<BlockRef>& blocks, const Marginal& m) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(m.hessian);
  const Eigen::VectorXd& values = eigen.eigenvalues();
  const double floor = 1e-12 * values[values.size() - 1];
  Eigen::Index first = 0;
  while (first < values.size() && !(values[first] > floor)) ++first;
  const Eigen::Index rank = values.size() - first;
  const Eigen::VectorXd roots = values.tail(rank).cwiseSqrt();
  const Eigen::MatrixXd vectors = eigen.eigenvectors().rightCols(rank);

  Factor factor;
  factor.kind = FactorKind::kPrior;
  std::vector<PriorBlock> prior_blocks;
  for (const BlockRef& block : blocks) {
    const bool is_pose = block.kind == BlockRef::Kind::kPose;
    prior_blocks.push_back(
        {is_pose, Eigen::Map<const Eigen::VectorXd>(graph.Parameters(block), is_pose ? 7 : 12)});
    factor.blocks.push_back({block.kind, block.index - 1});
  }
  factor.cost = std::make_shared<PriorResidual>(
      std::move(prior_blocks), roots.asDiagonal() * vectors.transpose(),
      roots.cwiseInverse().asDiagonal() * (vectors.transpose() * m.gradient));
  return factor;
}

}  // namespace

std::vector<bool> UsedByMarginalisation(const Graph& graph) {
  std::vector<bool> point_leaves(graph.points.size(), false), use(graph.factors.size(), false);
  for (const Factor& factor : graph.factors) {
    const BlockRef& last = factor.blocks.back();
    if (last.kind == BlockRef::Kind::kPoint && factor.blocks.front().index == 0) {
      point_leaves[static_cast<size_t>(last.index)] = true;
    }
  }
  for (size_t f = 0; f < graph.factors.size(); ++f) {
    for (const BlockRef& block : graph.factors[f].blocks) {
      const bool leaves = block.kind == BlockRef::Kind::kPoint
                              ? static_cast<bool>(point_leaves[static_cast<size_t>(block.index)])
                              : block.index == 0;
      if (leaves) use[f] = true;
    }
  }
  return use;
}

QuadraticForm<Eigen::Dynamic> EliminateFirst(const LinearSystem& system) {
  const int n = system.hessian.size() - 1;
  QuadraticForm<Eigen::Dynamic> out;
  out.hessian.resize(kBlockSize * n, kBlockSize * n);
  out.gradient = system.gradient.tail(kBlockSize * n);
  const BlockBandedMatrix::Block first = system.hessian.At(0, 0).selfadjointView<Eigen::Lower>();
  const Eigen::LLT<BlockBandedMatrix::Block> leaving(first);
  const BlockVector by_gradient = leaving.solve(system.gradient.head<kBlockSize>());
  for (int i = 0; i < n; ++i) {
    const BlockBandedMatrix::Block& cross_i = system.hessian.At(i + 1, 0);
    out.gradient.segment<kBlockSize>(kBlockSize * i) -= cross_i * by_gradient;
    for (int j = 0; j <= i; ++j) {
      const BlockBandedMatrix::Block gain = leaving.solve(system.hessian.At(j + 1, 0).transpose());
      BlockBandedMatrix::Block block = system.hessian.At(i + 1, j + 1);
      if (i == j) block = block.selfadjointView<Eigen::Lower>();
      block.noalias() -= cross_i * gain;
      if (i == j) block = (0.5 * (block + block.transpose())).eval();
      out.hessian.block<kBlockSize, kBlockSize>(kBlockSize * i, kBlockSize * j) = block;
      out.hessian.block<kBlockSize, kBlockSize>(kBlockSize * j, kBlockSize * i) = block.transpose();
    }
  }
  return out;
}

Factor GaussianPrior(const std::vector<GraphState>& states, const Eigen::MatrixXd& hessian,
                     const Eigen::VectorXd& gradient) {
  Graph graph;  // of the state that has left and those
  graph.states = {states.front()};
  graph.states.insert(graph.states.end(), states.begin(), states.end());
  std::vector<BlockRef> blocks;
  for (int k = 1; k <= static_cast<int>(states.size()); ++k) {
    blocks.push_back({BlockRef::Kind::kPose, k});
    blocks.push_back({BlockRef::Kind::kRates, k});
  }
  return MakePriorFactor(graph, blocks, {{}, hessian, gradient, 0});
}

std::optional<Factor> MarginalizeFirstState(const Graph& graph) {
  const std::vector<bool> use = UsedByMarginalisation(graph);
  const std::vector<BlockRef> blocks = RemainingBlocks(graph, use);
  if (blocks.empty()) return std::nullopt;
  return MakePriorFactor(graph, blocks, SchurComplement(Linearize(graph, use), blocks));
}

}  // namespace tagtwist::internal
