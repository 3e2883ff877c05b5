#include <cmath>
#include <optional>

#include "estimator/graph/linear_system.h"
#include "estimator/linear/block_banded.h"
#include "estimator/systematic/systematic_errors.h"

namespace tagtwist::internal {
namespace {

constexpr int kSize = BlockBandedMatrix::kSize;

// J'F root of each state: what a unit of each column adds to the right side of its pose.
using Push = Eigen::Matrix<double, 6, Eigen::Dynamic>;

Push PushOn(const SystematicBasis& basis, const SystematicErrors& errors, const NoiseModel& noise,
            const GraphFrame& frame) {
  Push out = Push::Zero(6, errors.root.cols());
  SystematicBasis::TagTerms tag;
  for (const TagDetection& seen : frame.tags) {
    if (!basis.Linearize(noise, frame.state.world_from_body, seen, &tag)) continue;
    const Push of_pose = tag.by_pose.transpose() * tag.by_parameters;
    for (size_t j = 0; j < tag.columns.size(); ++j) {
      out += of_pose.col(static_cast<Eigen::Index>(j)) * errors.root.row(tag.columns[j]);
    }
  }
  return out;
}

// Sums over states of one column's shifts: of their squares, and of themselves, in the body.
struct ShiftSums {
  double rotation = 0, position = 0;
  Eigen::Vector3d common_rotation = Eigen::Vector3d::Zero();
  Eigen::Vector3d common_position = Eigen::Vector3d::Zero();
};

ShiftSums AddShift(const Eigen::VectorXd& shift, const Graph& graph, Trajectory* trajectory,
                   std::vector<StateCovariance>* covariances) {
  ShiftSums out;
  for (size_t k = 0; k < graph.states.size(); ++k) {
    const auto at = shift.segment<kSize>(static_cast<Eigen::Index>(k) * kSize);
    trajectory->covariances[k] += at * at.transpose();
    (*covariances)[k] += at.head<12>() * at.head<12>().transpose();
    if (k > 0) {
      const auto before = shift.segment<kSize>(static_cast<Eigen::Index>(k - 1) * kSize);
      trajectory->cross_covariances[k - 1] += at * before.transpose();
    }
    out.rotation += at.head<3>().squaredNorm();
    out.position += at.segment<3>(3).squaredNorm();
    out.common_rotation += at.head<3>();
    out.common_position += graph.states[k].pose.rotation().conjugate() * at.segment<3>(3);
  }
  return out;
}

}  // namespace

SystematicShare AddSystematicErrors(const SystematicBasis& basis, const SystematicErrors& errors,
                                    const NoiseModel& noise, const Graph& graph,
                                    const std::vector<GraphFrame>& frames, Trajectory* trajectory,
                                    std::vector<StateCovariance>* covariances) {
  SystematicShare out{errors.field_sigma_px, std::hypot(errors.tag_sigma_m, errors.map_sigma_m),
                      errors.bias_sigma_px, errors.mount_sigma_rad, errors.mount_sigma_m};
  if (errors.None()) return out;
  const BlockBandedCholesky cholesky(Linearize(graph).hessian);
  if (!cholesky.ok()) return out;
  std::vector<Push> pushes;
  for (const GraphFrame& frame : frames) pushes.push_back(PushOn(basis, errors, noise, frame));
  double rotation = 0, position = 0, common_rotation = 0, common_position = 0;
  const auto n = static_cast<double>(frames.size());
  for (Eigen::Index column = 0; column < errors.root.cols(); ++column) {
    Eigen::VectorXd push = Eigen::VectorXd::Zero(kSize * static_cast<Eigen::Index>(frames.size()));
    for (size_t k = 0; k < pushes.size(); ++k) {
      push.segment<6>(static_cast<Eigen::Index>(k) * kSize) = pushes[k].col(column);
    }
    const ShiftSums sums = AddShift(cholesky.Solve(push), graph, trajectory, covariances);
    rotation += sums.rotation / n;
    position += sums.position / n;
    common_rotation += (sums.common_rotation / n).squaredNorm();
    common_position += (sums.common_position / n).squaredNorm();
  }
  out.rotation_rad = std::sqrt(rotation);
  out.position_m = std::sqrt(position);
  out.common_rotation_rad = std::sqrt(common_rotation);
  out.common_position_m = std::sqrt(common_position);
  return out;
}

}  // namespace tagtwist::internal
