#include "estimator/start/pose_path.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "estimator/graph/pose_bound.h"
#include "estimator/graph/reprojection.h"

namespace tagtwist::internal {
namespace {

constexpr double kCornerPx = 0.3;
constexpr double kRateRadps = 1;

// A pose of a frame as an end of paths.
struct Node {
  Eigen::Matrix3d attitude_covariance = Eigen::Matrix3d::Zero();
  double cost = 0;  // of the best path to here
  size_t from = 0;  // its pose in the frame before
};

double CornerCost(const EstimatorSetup& setup, const PoseChoice& choice, const Pose& pose) {
  GraphFrame frame;
  frame.tags = choice.tags;
  frame.state.world_from_body = pose;
  double sum = 0;
  for (const double error_px : ReprojectionErrors(setup, frame)) sum += error_px * error_px;
  return sum / (kCornerPx * kCornerPx);
}

// Only a choice, or an end of the way to one, has a cost: the rest is common to all paths.
std::vector<Node> NodesOf(const EstimatorSetup& setup, const PoseChoice& choice) {
  std::vector<Node> nodes(choice.poses.size());
  for (size_t i = 0; i < nodes.size(); ++i) {
    const auto bound = PoseBound(setup, kCornerPx, choice.poses[i], choice.tags);
    if (bound) nodes[i].attitude_covariance = bound->topLeftCorner<3, 3>();
    nodes[i].cost = CornerCost(setup, choice, choice.poses[i]);
  }
  return nodes;
}

double TurnCost(const Pose& a, const Node& node_a, const Pose& b, const Node& node_b, double dt_s) {
  const double turn_rad = kRateRadps * dt_s;
  const Eigen::Matrix3d covariance = node_a.attitude_covariance + node_b.attitude_covariance +
                                     turn_rad * turn_rad * Eigen::Matrix3d::Identity();
  const Eigen::Vector3d turn = Difference(b, a).head<3>();
  return turn.dot(covariance.llt().solve(turn));
}

void Extend(const PoseChoice& before, const std::vector<Node>& ends, const PoseChoice& next,
            std::vector<Node>* nodes) {
  const double dt_s = ToSeconds(next.t_ns - before.t_ns);
  for (size_t i = 0; i < nodes->size(); ++i) {
    Node& node = (*nodes)[i];
    double best = std::numeric_limits<double>::infinity();
    for (size_t j = 0; j < ends.size(); ++j) {
      const double cost =
          ends[j].cost + TurnCost(before.poses[j], ends[j], next.poses[i], node, dt_s);
      if (cost < best) best = cost, node.from = j;
    }
    node.cost += best;
  }
}

}  // namespace

std::vector<std::optional<Pose>> LikeliestPath(const EstimatorSetup& setup,
                                               const std::vector<PoseChoice>& choices) {
  std::vector<std::optional<Pose>> out(choices.size());
  std::vector<size_t> frames;
  for (size_t k = 0; k < choices.size(); ++k) {
    if (!choices[k].poses.empty()) frames.push_back(k);
  }
  const auto is_open = [&](size_t i) {
    return i < frames.size() && choices[frames[i]].poses.size() > 1;
  };
  std::vector<std::vector<Node>> nodes;
  for (size_t i = 0; i < frames.size(); ++i) {
    const bool after_open = i > 0 && is_open(i - 1);
    const bool matters = is_open(i) || after_open || is_open(i + 1);
    nodes.push_back(matters ? NodesOf(setup, choices[frames[i]]) : std::vector<Node>(1));
    if (i > 0 && (is_open(i) || after_open)) {
      Extend(choices[frames[i - 1]], nodes[i - 1], choices[frames[i]], &nodes[i]);
    }
  }
  if (frames.empty()) return out;
  const auto cheaper = [](const Node& a, const Node& b) { return a.cost < b.cost; };
  auto at = static_cast<size_t>(
      std::min_element(nodes.back().begin(), nodes.back().end(), cheaper) - nodes.back().begin());
  for (size_t k = frames.size(); k-- > 0;) {
    out[frames[k]] = choices[frames[k]].poses[at];
    at = nodes[k][at].from;
  }
  return out;
}

}  // namespace tagtwist::internal
