#include "estimator/graph/graph.h"

#include <cmath>

namespace tagtwist::internal {

std::vector<GraphState> Retract(const std::vector<GraphState>& states,
                                const Eigen::VectorXd& step) {
  std::vector<GraphState> out;
  out.reserve(states.size());
  for (const GraphState& state : states) {
    out.push_back(Retract(state, step.segment<18>(18 * static_cast<Eigen::Index>(out.size()))));
  }
  return out;
}

Eigen::VectorXd Difference(const std::vector<GraphState>& states,
                           const std::vector<GraphState>& references) {
  Eigen::VectorXd out(18 * static_cast<Eigen::Index>(references.size()));
  for (size_t k = 0; k < references.size(); ++k) {
    out.segment<18>(18 * static_cast<Eigen::Index>(k)) = Difference(states[k], references[k]);
  }
  return out;
}

double Factor::LogDetInformation() const {
  return own_log_det + cost->num_residuals() * std::log(information);
}

const double* Graph::Parameters(const BlockRef& block) const {
  const auto index = static_cast<size_t>(block.index);
  switch (block.kind) {
    case BlockRef::Kind::kPose:
      return states[index].pose.params.data();
    case BlockRef::Kind::kRates:
      return states[index].rates.data();
    case BlockRef::Kind::kPoint:
      return points[index].data();
  }
  return nullptr;
}

double* Graph::Parameters(const BlockRef& block) {
  return const_cast<double*>(static_cast<const Graph*>(this)->Parameters(block));
}

}  // namespace tagtwist::internal
