#include "estimator/motion/bank/tags_alone.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <vector>

#include "estimator/graph/pose_bound.h"
#include "estimator/rig/rig_pose.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/base/statistics/robust.h"
#include "frontend/types/so3.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

using Residual8 = Eigen::Matrix<double, 8, 1>;
using Jacobian8 = Eigen::Matrix<double, 8, 6>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

constexpr int kMostIterations = 10;
constexpr double kSettled = 1e-3;  // rad or m times standard deviations, as a solve neglects

// Normal equations of the tags at a pose.
struct Normals {
  PoseCovariance hessian = PoseCovariance::Zero();
  Vector6 gradient = Vector6::Zero();
  double squares = 0;
  size_t n_fitting = 0;  // tags
};

struct LinearTag {
  Residual8 residual;
  Jacobian8 jacobian;
};

// What chance makes of a sum of squares hardly ever (Wilson and Hilferty, 4 deviations).
double MostChi2(double freedom) {
  return freedom * std::pow(1 - 2 / (9 * freedom) + 4 * std::sqrt(2 / (9 * freedom)), 3);
}

// nullopt where a corner cannot be seen from there.
std::optional<Normals> Linearise(const std::vector<TagReprojection>& tags, double huber_delta,
                                 const Pose& pose) {
  std::vector<LinearTag> linear(tags.size());
  std::vector<double> squared_norms;
  squared_norms.reserve(tags.size());
  for (size_t i = 0; i < tags.size(); ++i) {
    LinearTag& tag = linear[i];
    if (!tags[i].Linearize(pose.params.data(), &tag.residual, &tag.jacobian)) return std::nullopt;
    squared_norms.push_back(tag.residual.squaredNorm());
  }
  // Against what most tags show, which is much where the pose is still far off.
  constexpr double kMedianChi2Of8 = 7.344;
  const double typical = Quantile(squared_norms, 0.5) / kMedianChi2Of8;
  const double delta = huber_delta * std::sqrt(std::max(1.0, typical));
  Normals out;
  for (size_t i = 0; i < tags.size(); ++i) {
    const double norm = std::sqrt(squared_norms[i]), weight = norm > delta ? delta / norm : 1;
    const LinearTag& tag = linear[i];
    out.squares += weight * squared_norms[i];
    if (squared_norms[i] < MostChi2(8)) ++out.n_fitting;
    out.hessian.noalias() += weight * tag.jacobian.transpose().lazyProduct(tag.jacobian);
    out.gradient.noalias() += weight * tag.jacobian.transpose().lazyProduct(tag.residual);
  }
  return out;
}

// By how much the squares exceed what chance makes of them hardly ever; 1 where they do not.
double Misfit(const Normals& tags, size_t n_tags) {
  const double freedom = 8.0 * static_cast<double>(n_tags) - 6;
  const Vector6 step = tags.hessian.ldlt().solve(tags.gradient);
  const double misfit = (tags.squares - tags.gradient.dot(step)) / freedom;
  return misfit > MostChi2(freedom) / freedom ? misfit : 1;
}

// A tag that several cameras see agrees with nothing but itself.
bool HasTwoIds(const std::vector<TagDetection>& tags) {
  return std::any_of(tags.begin(), tags.end(),
                     [&](const TagDetection& tag) { return tag.id != tags.front().id; });
}

bool MostAgree(const Normals& tags, size_t n_tags, double misfit) {
  if (n_tags == 2) return tags.n_fitting == 2 && misfit == 1;
  return tags.n_fitting > 2 && 2 * tags.n_fitting > n_tags;
}

// Whether another pose, beyond what one trough of both may hold, explains the tags nearly as well.
bool IsMirrorOpen(const std::vector<TagReprojection>& tags, double huber_delta, double squares,
                  const Pose& pose, const Pose& mirrored) {
  constexpr double kOpenRad = 0.0873, kDecided = 18;  // 5 degrees; twice the logarithm of odds
  if (AngleBetween(pose, mirrored) < kOpenRad) return false;
  const auto there = Linearise(tags, huber_delta, mirrored);
  return there && there->squares - squares < kDecided;
}

// Least squares of the tags.
struct Alone {
  Pose world_from_body;
  Normals normals;
  PoseCovariance covariance = PoseCovariance::Zero();  // grown by the misfit
  double misfit = 1;
  bool is_only = true;      // no mirrored pose explains them as well
  bool is_settled = false;  // no further step would show
};

std::optional<Alone> SolveAlone(const EstimatorSetup& setup, double corner_sigma_px,
                                const std::vector<TagDetection>& tags, const Pose& start) {
  if (tags.empty()) return std::nullopt;
  std::vector<TagReprojection> residuals;
  residuals.reserve(tags.size());
  const FixedCameras cameras(setup);
  for (const TagDetection& tag : tags) {
    residuals.emplace_back(TagObservation{setup.map.CornersInWorld(tag.id), tag.corners,
                                          CornerCovariance(setup, tag, corner_sigma_px)},
                           cameras.Of(tag.camera));
  }
  const double delta = HuberDelta(setup.options.robust_scale, 8);
  Alone out;
  out.world_from_body = start;
  for (int i = 0; i < kMostIterations; ++i) {
    const auto normals = Linearise(residuals, delta, out.world_from_body);
    if (!normals) return std::nullopt;
    out.normals = *normals;
    const Vector6 step = -normals->hessian.ldlt().solve(normals->gradient);
    if (!step.allFinite()) return std::nullopt;
    out.world_from_body = Retract(out.world_from_body, step);
    out.is_settled = step.norm() * std::sqrt(step.dot(normals->hessian * step)) < kSettled;
    if (out.is_settled) break;
  }
  const auto covariance = InverseInformation(out.normals.hessian);
  if (!covariance) return std::nullopt;
  out.misfit = Misfit(out.normals, tags.size());
  out.covariance = out.misfit * *covariance;
  const auto mirrored = MirroredPoseOf(setup, tags, out.world_from_body);
  out.is_only = !(mirrored && IsMirrorOpen(residuals, delta, out.normals.squares,
                                           out.world_from_body, *mirrored));
  return out;
}

}  // namespace

std::optional<PoseMeasurement> PoseOfTags(const EstimatorSetup& setup, double corner_sigma_px,
                                          const std::vector<TagDetection>& tags,
                                          const Pose& start) {
  constexpr double kMostAttitudeSigma = 0.035;  // rad
  const auto alone = SolveAlone(setup, corner_sigma_px, tags, start);
  if (!alone) return std::nullopt;
  PoseMeasurement out;
  out.world_from_body = alone->world_from_body;
  out.attitude_covariance = alone->covariance.topLeftCorner<3, 3>();
  out.position_covariance = alone->covariance.bottomRightCorner<3, 3>();
  out.is_only = alone->is_only;
  out.open_rad2 = alone->covariance.topLeftCorner<3, 3>().trace() / 3;
  out.is_consensus =
      alone->is_only && HasTwoIds(tags) && MostAgree(alone->normals, tags.size(), alone->misfit);
  if (!(out.attitude_covariance.trace() < kMostAttitudeSigma * kMostAttitudeSigma)) {
    return std::nullopt;
  }
  return out;
}

std::optional<int> LoneTag(const std::vector<TagDetection>& tags) {
  if (tags.empty() || HasTwoIds(tags)) return std::nullopt;
  return tags.front().id;
}

std::optional<PoseMeasurement> MotionShownByLoneTag(const EstimatorSetup& setup,
                                                    double corner_sigma_px,
                                                    const std::vector<TagDetection>& tags,
                                                    const Pose& start) {
  constexpr double kLeastSine = 0.05;
  constexpr double kMostOpenRad = 0.05;  // an axis; beyond, errors are of other kinds
  const auto id = LoneTag(tags);
  if (!id || setup.HasRollingShutter()) return std::nullopt;
  const auto alone = SolveAlone(setup, corner_sigma_px, tags, start);
  if (!alone || alone->misfit != 1 || !alone->is_settled) return std::nullopt;
  const double open_rad2 = alone->covariance.topLeftCorner<3, 3>().trace() / 3;
  if (!(open_rad2 < kMostOpenRad * kMostOpenRad)) return std::nullopt;
  const auto& corners = setup.map.CornersInWorld(*id);
  const Eigen::Vector3d centre_in_world = (corners[0] + corners[1] + corners[2] + corners[3]) / 4;
  const Eigen::Matrix3d body_from_world =
      alone->world_from_body.rotation().conjugate().toRotationMatrix();
  // The tag's centre and a side of it, in B.
  const Eigen::Vector3d p =
      body_from_world * (centre_in_world - alone->world_from_body.translation());
  const Eigen::Vector3d side = body_from_world * (corners[1] - corners[0]).normalized();
  const Eigen::Vector3d z = p.normalized();
  const double sine = z.cross(side).norm();
  if (!(sine > kLeastSine)) return std::nullopt;
  const Eigen::Vector3d y = z.cross(side) / sine, x = y.cross(z);
  // By the pose's attitude (in B) and position (in W).
  Eigen::Matrix<double, 3, 6> of_p, of_turn;
  of_p << Hat(p), -body_from_world;
  of_turn = -Hat(p) * of_p / p.squaredNorm();
  Eigen::Matrix<double, 3, 6> of_side = -Hat(side) * of_turn;
  of_side.leftCols<3>() += Hat(side);
  of_turn -= z * (y.transpose() * of_side) / sine;
  Eigen::Matrix3d turned;
  turned << x.transpose(), y.transpose(), z.transpose();
  PoseMeasurement out;
  out.world_from_body = MakePose(Eigen::Quaterniond(turned), -p);
  out.is_only = alone->is_only;
  out.open_rad2 = open_rad2;
  out.attitude_covariance = of_turn * alone->covariance * of_turn.transpose();
  out.position_covariance = of_p * alone->covariance * of_p.transpose();
  return out;
}

}  // namespace tagtwist::internal
