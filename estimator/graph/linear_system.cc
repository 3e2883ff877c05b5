#include "estimator/graph/linear_system.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "frontend/base/statistics/robust.h"
#include "frontend/base/take_shape.h"
#include "residuals/motion_residual.h"
#include "residuals/pose_manifold.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// Where a block starts in the error state of its state.
int OffsetInState(BlockRef::Kind kind) { return kind == BlockRef::Kind::kPose ? 0 : 6; }

// What the factors on one point have said so far.
struct PointSystem {
  Eigen::Matrix2d hessian = Eigen::Matrix2d::Zero();
  Eigen::Vector2d gradient = Eigen::Vector2d::Zero();
  std::vector<std::pair<int, Eigen::Matrix<double, 6, 2>>> pose_point;  // state, H(pose, point)
};

void AddTag(int state, const LinearFactor& linear, LinearSystem* system) {
  const Eigen::Map<const Eigen::Matrix<double, 8, 6>> jacobian(linear.jacobian.data());
  const Eigen::Map<const Eigen::Matrix<double, 8, 1>> residual(linear.residual.data());
  system->hessian.At(state, state).topLeftCorner<6, 6>() +=
      jacobian.transpose().lazyProduct(jacobian);
  system->gradient.segment<6>(kBlockSize * state) += jacobian.transpose().lazyProduct(residual);
}

// A part of the motion from a state to the next, whose rows and columns are three triples. kAxes is
// 3, or 1 where the axes are alike and share nothing, so that one of them tells all.
template <int kAxes>
void AddMotion(int state, const MotionResidual::Part& part, const LinearFactor& linear,
               LinearSystem* system) {
  using Matrix = Eigen::Matrix<double, 3 * kAxes, 3 * kAxes>;
  const Eigen::Map<const Eigen::Matrix<double, 18, 36>> jacobian(linear.jacobian.data());
  const Eigen::Map<const Eigen::Matrix<double, 18, 1>> residual(linear.residual.data());
  std::array<Matrix, 2> j;
  std::array<Eigen::Matrix3d, 2> gradient = {Eigen::Matrix3d::Zero(), Eigen::Matrix3d::Zero()};
  for (int k = 0; k < 18; ++k) {
    const int s = k / 9, row = k / 3 % 3, i = k % 3, column = part.columns[static_cast<size_t>(i)];
    const auto entry =
        jacobian.block<kAxes, kAxes>(part.first_row + 3 * row, kBlockSize * s + column);
    j[static_cast<size_t>(s)].template block<kAxes, kAxes>(kAxes * row, kAxes * i) = entry;
    auto of_entry = gradient[static_cast<size_t>(s)].col(i);
    const auto of_row = residual.segment<3>(part.first_row + 3 * row);
    if constexpr (kAxes == 3) of_entry += entry.transpose().lazyProduct(of_row);
    if constexpr (kAxes == 1) of_entry += entry(0, 0) * of_row;
  }
  for (int k = 0; k < 6; ++k) {
    const int column = part.columns[static_cast<size_t>(k % 3)];
    system->gradient.segment<3>(kBlockSize * (state + k / 3) + column) +=
        gradient[static_cast<size_t>(k / 3)].col(k % 3);
  }
  for (const auto& [a, b] : {std::pair{0, 0}, {1, 0}, {1, 1}}) {
    const auto& j_a = j[static_cast<size_t>(a)];
    const Matrix product = j_a.transpose().lazyProduct(j[static_cast<size_t>(b)]);
    auto& block = system->hessian.At(state + a, state + b);
    for (int c = 0; c < 9; ++c) {
      auto to = block.template block<3, 3>(part.columns[static_cast<size_t>(c / 3)],
                                           part.columns[static_cast<size_t>(c % 3)]);
      const auto from = product.template block<kAxes, kAxes>(kAxes * (c / 3), kAxes * (c % 3));
      if constexpr (kAxes == 3) to += from;
      if constexpr (kAxes == 1) to.diagonal().array() += from(0, 0);
    }
  }
}

// Of any kind.
void AddStateBlocks(const Factor& factor, const LinearFactor& linear, int first_state,
                    LinearSystem* system) {
  int column_a = 0;
  for (const BlockRef& a : factor.blocks) {
    const int size_a = TangentSize(a.kind);
    if (a.kind != BlockRef::Kind::kPoint) {
      const auto jacobian_a = linear.jacobian.middleCols(column_a, size_a);
      const int row = a.index - first_state;
      system->gradient.segment(kBlockSize * row + OffsetInState(a.kind), size_a).noalias() +=
          jacobian_a.transpose() * linear.residual;
      int column_b = 0;
      for (const BlockRef& b : factor.blocks) {
        if (b.kind != BlockRef::Kind::kPoint && b.index <= a.index) {
          system->hessian.At(row, b.index - first_state)
              .block(OffsetInState(a.kind), OffsetInState(b.kind), size_a, TangentSize(b.kind))
              .noalias() +=
              jacobian_a.transpose() * linear.jacobian.middleCols(column_b, TangentSize(b.kind));
        }
        column_b += TangentSize(b.kind);
      }
    }
    column_a += size_a;
  }
}

// A track factor: pose first, point second.
void AddPoint(const Factor& factor, const LinearFactor& linear, PointSystem* point) {
  const auto d_pose = linear.jacobian.leftCols<6>();
  const auto d_point = linear.jacobian.rightCols<2>();
  point->hessian.noalias() += d_point.transpose() * d_point;
  point->gradient.noalias() += d_point.transpose() * linear.residual;
  point->pose_point.emplace_back(factor.blocks[0].index, d_pose.transpose() * d_point);
}

// Inverse of a positive semidefinite matrix where it has information, else zero: a direction that
// no view shows ties the point to no pose either.
Eigen::Matrix2d PseudoInverse(const Eigen::Matrix2d& matrix) {
  constexpr double kRounding = 1e-14;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d> eigen(matrix);
  Eigen::Vector2d inverse = Eigen::Vector2d::Zero();
  for (int i = 0; i < 2; ++i) {
    const double value = eigen.eigenvalues()[i];
    if (value > kRounding * eigen.eigenvalues()[1]) inverse[i] = 1 / value;
  }
  return eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
}

void EliminatePoint(const PointSystem& point, LinearSystem* system) {
  if (point.pose_point.empty()) return;
  const Eigen::Matrix2d inverse = PseudoInverse(point.hessian);
  for (const auto& [a, pose_point_a] : point.pose_point) {
    const Eigen::Matrix<double, 6, 2> gain = pose_point_a * inverse;
    system->gradient.segment<6>(kBlockSize * a).noalias() -= gain * point.gradient;
    for (const auto& [b, pose_point_b] : point.pose_point) {
      if (b > a) continue;
      system->hessian.At(a, b).topLeftCorner<6, 6>().noalias() -= gain * pose_point_b.transpose();
    }
  }
}

// Factors of all shapes come after one another into the same memory.
template <typename Residual, typename Jacobian>
void Take(const Residual& residual, const Jacobian& jacobian, LinearFactor* out) {
  TakeShape(residual.rows(), 1, &out->residual);
  TakeShape(jacobian.rows(), jacobian.cols(), &out->jacobian);
  out->residual = residual;
  out->jacobian = jacobian;
}

// LinearizeFactor before its loss: the many factors without detours, others by their cost.
bool LinearizeTag(const Graph& graph, const Factor& factor, LinearFactor* out) {
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> jacobian;
  if (!static_cast<const TagReprojectionResidual&>(*factor.cost)
           .Linearize(graph.Parameters(factor.blocks[0]), &residual, &jacobian)) {
    return false;
  }
  Take(residual, jacobian, out);
  return true;
}

void LinearizeMotion(const Graph& graph, const Factor& factor, LinearFactor* out) {
  Eigen::Matrix<double, 18, 1> residual;
  Eigen::Matrix<double, 18, 36> jacobian;
  std::array<const double*, 4> parameters;
  for (size_t i = 0; i < 4; ++i) parameters[i] = graph.Parameters(factor.blocks[i]);
  static_cast<const MotionResidual&>(*factor.cost)
      .Linearize(parameters.data(), &residual, &jacobian);
  Take(residual, jacobian, out);
}

bool LinearizeAny(const Graph& graph, const Factor& factor, LinearFactor* out) {
  const auto& sizes = factor.cost->parameter_block_sizes();
  const int rows = factor.cost->num_residuals();
  std::vector<const double*> parameters;
  std::vector<RowMajor> ambient;
  std::vector<double*> pointers;
  int columns = 0;
  ambient.reserve(sizes.size());
  for (size_t i = 0; i < sizes.size(); ++i) {
    parameters.push_back(graph.Parameters(factor.blocks[i]));
    ambient.emplace_back(rows, sizes[i]);
    pointers.push_back(ambient.back().data());
    columns += TangentSize(factor.blocks[i].kind);
  }
  TakeShape(rows, 1, &out->residual);
  if (!factor.cost->Evaluate(parameters.data(), out->residual.data(), pointers.data())) {
    return false;
  }
  TakeShape(rows, columns, &out->jacobian);
  int column = 0;
  for (size_t i = 0; i < sizes.size(); ++i) {
    const int size = TangentSize(factor.blocks[i].kind);
    if (factor.blocks[i].kind == BlockRef::Kind::kPose) {
      Eigen::Matrix<double, 7, 6, Eigen::RowMajor> plus;
      PoseManifold().PlusJacobian(parameters[i], plus.data());
      out->jacobian.middleCols(column, size).noalias() = ambient[i] * plus;
    } else {
      out->jacobian.middleCols(column, size) = ambient[i];
    }
    column += size;
  }
  return true;
}

}  // namespace

int TangentSize(BlockRef::Kind kind) {
  switch (kind) {
    case BlockRef::Kind::kPose:
      return 6;
    case BlockRef::Kind::kRates:
      return 12;
    case BlockRef::Kind::kPoint:
      return 2;
  }
  return 0;
}

bool LinearizeFactor(const Graph& graph, const Factor& factor, LinearFactor* out) {
  if (factor.kind == FactorKind::kTag) {
    if (!LinearizeTag(graph, factor, out)) return false;
  } else if (factor.kind == FactorKind::kMotion) {
    LinearizeMotion(graph, factor, out);
  } else if (!LinearizeAny(graph, factor, out)) {
    return false;
  }
  out->weight = Huber(factor.information * out->residual.squaredNorm(), factor.huber_delta).weight;
  const double scale = std::sqrt(factor.information * out->weight);
  if (scale != 1) {
    out->residual *= scale;
    out->jacobian *= scale;
  }
  return true;
}

double RobustCost(const Factor& factor, const LinearFactor& linear) {
  return Huber(linear.residual.squaredNorm() / linear.weight, factor.huber_delta).cost;
}

void AddFactor(const Factor& factor, const LinearFactor& linear, LinearSystem* system,
               int first_state) {
  const int state = factor.blocks[0].index - first_state;
  if (factor.kind == FactorKind::kTag) {
    AddTag(state, linear, system);
  } else if (factor.kind == FactorKind::kMotion) {
    AddMotion<3>(state, MotionResidual::kAngular, linear, system);
    AddMotion<1>(state, MotionResidual::kLinear, linear, system);
  } else {
    AddStateBlocks(factor, linear, first_state, system);
  }
}

int Bandwidth(const Graph& graph, const std::vector<bool>& use) {
  int bandwidth = 1;
  std::vector<std::array<int, 2>> spans(graph.points.size(), {-1, -1});
  for (size_t f = 0; f < graph.factors.size(); ++f) {
    if (!use.empty() && !use[f]) continue;
    int low = -1, high = -1;
    for (const BlockRef& block : graph.factors[f].blocks) {
      if (block.kind == BlockRef::Kind::kPoint) {
        auto& span = spans[static_cast<size_t>(block.index)];
        span[0] = span[0] < 0 ? low : std::min(span[0], low);
        span[1] = std::max(span[1], high);
        low = span[0], high = span[1];
        continue;
      }
      low = low < 0 ? block.index : std::min(low, block.index);
      high = std::max(high, block.index);
    }
    bandwidth = std::max(bandwidth, high - low);
  }
  return bandwidth;
}

LinearSystem ZeroSystem(int size, int bandwidth, BlockBandedMatrix memory) {
  memory.SetZero(size, std::min(size - 1, bandwidth));
  return {std::move(memory), Eigen::VectorXd::Zero(kBlockSize * size), 0, true};
}

LinearSystem Linearize(const Graph& graph, const std::vector<bool>& use, BlockBandedMatrix memory) {
  LinearSystem system =
      ZeroSystem(static_cast<int>(graph.states.size()), Bandwidth(graph, use), std::move(memory));
  std::vector<PointSystem> points(graph.points.size());
  LinearFactor linear;
  for (size_t f = 0; f < graph.factors.size(); ++f) {
    if (!use.empty() && !use[f]) continue;
    const Factor& factor = graph.factors[f];
    if (!LinearizeFactor(graph, factor, &linear)) {
      system.is_whole = false;
      continue;
    }
    system.cost += RobustCost(factor, linear);
    AddFactor(factor, linear, &system);
    if (factor.blocks.back().kind == BlockRef::Kind::kPoint) {
      AddPoint(factor, linear, &points[static_cast<size_t>(factor.blocks.back().index)]);
    }
  }
  for (const PointSystem& point : points) EliminatePoint(point, &system);
  return system;
}

}  // namespace tagtwist::internal
