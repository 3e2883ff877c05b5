#include "estimator/solve/pose_form.h"

#include <cmath>

namespace tagtwist::internal {
namespace {

void Add(const LinearFactor& linear, double cost, QuadraticForm<6, Pose>* form) {
  using Eigen::Dynamic;
  const Eigen::Index rows = linear.residual.size();
  if (rows == 8) {  // most are tags
    form->Add(Eigen::Map<const Eigen::Matrix<double, 8, 6>>(linear.jacobian.data()),
              Eigen::Map<const Eigen::Matrix<double, 8, 1>>(linear.residual.data()), cost);
  } else {
    form->Add(Eigen::Map<const Eigen::Matrix<double, Dynamic, 6>>(linear.jacobian.data(), rows, 6),
              linear.residual, cost);
  }
}

}  // namespace

bool PoseForm::Linearize(const Graph& graph, LinearFactor* scratch) {
  is_stale = is_robust = is_partial = false;
  form = {};
  squared_norms.assign(factors.size(), 0);
  if (factors.empty()) return true;
  const Factor& first = graph.factors[factors.front()];
  form.reference = graph.states[static_cast<size_t>(first.blocks.front().index)].pose;
  information = first.information;
  for (size_t i = 0; i < factors.size(); ++i) {
    const Factor& factor = graph.factors[factors[i]];
    if (factor.information != information) information = 0;
    if (!LinearizeFactor(graph, factor, scratch)) {
      is_partial = true;
      continue;
    }
    squared_norms[i] = scratch->residual.squaredNorm() / scratch->weight;
    is_robust = is_robust || scratch->weight < 1;
    Add(*scratch, RobustCost(factor, *scratch), &form);
  }
  return !is_partial;
}

double PoseForm::Scale(const Graph& graph) const {
  return information > 0 ? graph.factors[factors.front()].information / information : 1;
}

bool PoseForm::Holds(const Graph& graph, const Pose& pose, double neglected) const {
  if (factors.empty()) return true;
  if (is_stale) return false;
  const PoseStep moved = Difference(pose, form.reference);
  if (moved.isZero(0)) return true;
  const double sigmas = std::sqrt(Scale(graph) * moved.dot(form.hessian * moved));
  return moved.norm() * sigmas <= neglected;
}

double PoseForm::Weight(const Graph& graph, size_t i) const {
  const double delta = graph.factors[factors[i]].huber_delta, norm = std::sqrt(squared_norms[i]);
  return delta > 0 && norm > delta ? delta / norm : 1;
}

}  // namespace tagtwist::internal
