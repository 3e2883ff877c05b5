#include "estimator/graph/graph.h"

#include <cmath>

namespace tagtwist {

GraphState ToGraphState(int64_t t_ns, const BodyState& state, const Acceleration& acceleration) {
  GraphState out;
  out.t_ns = t_ns;
  out.pose = state.world_from_body;
  out.rates << state.twist.v_world, state.twist.omega_body, acceleration.a_world,
      acceleration.alpha_body;
  return out;
}

BodyState ToBodyState(const GraphState& state) {
  BodyState out;
  out.world_from_body = state.pose;
  out.twist.v_world = state.rates.segment<3>(0);
  out.twist.omega_body = state.rates.segment<3>(3);
  return out;
}

Acceleration ToAcceleration(const GraphState& state) {
  return {state.rates.segment<3>(6), state.rates.segment<3>(9)};
}

GraphState Retract(const GraphState& state, const GraphStep& step) {
  GraphState out = state;
  out.pose = Retract(state.pose, step.head<6>());
  out.rates += step.tail<12>();
  return out;
}

GraphStep Difference(const GraphState& state, const GraphState& reference) {
  GraphStep out;
  out << Difference(state.pose, reference.pose), state.rates - reference.rates;
  return out;
}

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

}  // namespace tagtwist
