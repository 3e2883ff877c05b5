#include "estimator/hand_eye.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>

#include "frontend/types/so3.h"

namespace tagtwist {
namespace {

// Unknowns: [A rotation, A translation, M rotation, M translation, offset]; rotations are
// perturbed on the right.
using Vector13 = Eigen::Matrix<double, 13, 1>;
using Matrix13 = Eigen::Matrix<double, 13, 13>;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Jacobian = Eigen::Matrix<double, 6, 13>;

Vector6 Misfit(const TruthMatch& match, const Alignment& alignment, double metres_per_radian) {
  const Pose predicted =
      alignment.truth_from_world * match.estimate.world_from_body * alignment.body_from_marker;
  const Pose& truth = match.truth.world_from_body;
  Vector6 r;
  r << predicted.translation() - truth.translation(),
      metres_per_radian * LogSo3(truth.rotation().conjugate() * predicted.rotation());
  return r;
}

Jacobian MisfitJacobian(const TruthMatch& match, const Alignment& alignment, const Vector6& misfit,
                        const Twist& rate, double metres_per_radian) {
  const Eigen::Matrix3d a = alignment.truth_from_world.rotation().toRotationMatrix();
  const Eigen::Matrix3d r = match.estimate.world_from_body.rotation().toRotationMatrix();
  const Eigen::Matrix3d m = alignment.body_from_marker.rotation().toRotationMatrix();
  const Eigen::Vector3d log = misfit.tail<3>() / metres_per_radian;
  const Eigen::Matrix3d log_from_right = metres_per_radian * RightJacobianInverseSo3(log);
  Jacobian j = Jacobian::Zero();
  j.block<3, 3>(0, 0) =
      -a * Hat(match.estimate.world_from_body * alignment.body_from_marker.translation());
  j.block<3, 3>(0, 3).setIdentity();
  j.block<3, 3>(0, 9) = a * r;
  j.block<3, 1>(0, 12) = -rate.v_world;
  j.block<3, 3>(3, 0) = log_from_right * (r * m).transpose();
  j.block<3, 3>(3, 6) = log_from_right;
  j.block<3, 1>(3, 12) = -metres_per_radian * RightJacobianInverseSo3(-log) * rate.omega_body;
  return j;
}

struct NormalEquations {
  Matrix13 hessian = Matrix13::Zero();
  Vector13 gradient = Vector13::Zero();
  double cost = 0;  // mean squared misfit
};

double Cost(const std::vector<TruthMatch>& matches, const Alignment& alignment, double weight) {
  double sum = 0;
  for (const TruthMatch& match : matches) sum += Misfit(match, alignment, weight).squaredNorm();
  return matches.empty() ? std::numeric_limits<double>::infinity()
                         : sum / static_cast<double>(matches.size());
}

NormalEquations Linearise(const std::vector<TruthMatch>& matches,
                          const std::vector<TruthSample>& truth, const Alignment& alignment,
                          const AlignmentOptions& options) {
  NormalEquations out;
  for (const TruthMatch& match : matches) {
    const Vector6 r = Misfit(match, alignment, options.metres_per_radian);
    Twist rate;
    if (options.estimate_time_offset) {
      rate = DifferentiateTruth(truth, match.truth.t_ns, options.max_truth_gap_s).value_or(Twist());
    }
    const Jacobian j = MisfitJacobian(match, alignment, r, rate, options.metres_per_radian);
    out.hessian += j.transpose() * j;
    out.gradient += j.transpose() * r;
    out.cost += r.squaredNorm();
  }
  out.cost /= static_cast<double>(matches.size());
  return out;
}

Alignment Step(const Alignment& from, const Vector13& d) {
  return {MakePose(from.truth_from_world.rotation() * ExpSo3(d.segment<3>(0)),
                   from.truth_from_world.translation() + d.segment<3>(3)),
          MakePose(from.body_from_marker.rotation() * ExpSo3(d.segment<3>(6)),
                   from.body_from_marker.translation() + d.segment<3>(9)),
          from.time_offset_s + d(12)};
}

}  // namespace

HandEyeResult RefineHandEye(const PoseSeries& series, const std::vector<TruthSample>& truth,
                            const Alignment& initial, const AlignmentOptions& options) {
  const auto match_at = [&](const Alignment& alignment) {
    return MatchTruth(series, truth, alignment.time_offset_s, options.max_truth_gap_s);
  };
  HandEyeResult best{initial, 0};
  std::vector<TruthMatch> matches = match_at(initial);
  if (matches.empty()) return {initial, std::numeric_limits<double>::infinity()};
  double damping = 1e-6;
  for (int iteration = 0; iteration < 100 && damping < 1e9; ++iteration) {
    const NormalEquations equations = Linearise(matches, truth, best.alignment, options);
    best.cost = equations.cost;
    Matrix13 damped = equations.hessian;
    damped.diagonal() += damping * equations.hessian.diagonal();
    damped.diagonal().array() += 1e-12;  // directions that nothing speaks of stay put
    const Vector13 step = -damped.ldlt().solve(equations.gradient);
    const Alignment candidate = Step(best.alignment, step);
    std::vector<TruthMatch> moved = match_at(candidate);
    if (!(Cost(moved, candidate, options.metres_per_radian) <= best.cost)) {
      damping *= 10;
      continue;
    }
    best.alignment = candidate;
    matches = std::move(moved);
    damping = std::max(damping / 10, 1e-12);
    if (step.norm() < 1e-12) break;
  }
  best.cost = Cost(matches, best.alignment, options.metres_per_radian);
  return best;
}

}  // namespace tagtwist
