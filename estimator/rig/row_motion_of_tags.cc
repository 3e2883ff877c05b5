#include "estimator/rig/row_motion_of_tags.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <utility>

#include "estimator/rig/rig_pose.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/base/statistics/robust.h"

namespace tagtwist::internal {
namespace {

constexpr Eigen::Index kUnknowns = 18;  // a step of the pose at the stamp, by_s, by_s2
constexpr int kTold = 12;               // of them that the rows tell rather than the prior
constexpr size_t kTell = 2;             // tags: the eight coordinates of one do not

using Step = Eigen::Matrix<double, kUnknowns, 1>;
using Information = Eigen::Matrix<double, kUnknowns, kUnknowns>;
using Motion = Eigen::Matrix<double, 12, 1>;  // by_s, by_s2

Motion MotionOf(const RowMotion& motion) {
  Motion out;
  out << motion.by_s, motion.by_s2;
  return out;
}

struct Prior {
  Motion mean = Motion::Zero();
  RowMotion::Covariance information = RowMotion::Covariance::Zero();

  Motion Gradient(const Motion& motion) const { return information * (motion - mean); }
  double Cost(const Motion& motion) const { return (motion - mean).dot(Gradient(motion)); }
};

// What bodies do, so that what few tags leave open stays within it.
Prior Bounds() {
  constexpr double kTurn = 10, kSpeed = 3;                  // rad/s, m/s: standard deviations
  constexpr double kTurnsChange = 100, kAcceleration = 30;  // rad/s^2, m/s^2
  const Eigen::Vector3d one = Eigen::Vector3d::Ones();
  Motion sigmas;
  sigmas << kTurn * one, kSpeed * one, 0.5 * kTurnsChange * one, 0.5 * kAcceleration * one;
  Prior out;
  out.information.diagonal() = sigmas.cwiseAbs2().cwiseInverse();
  return out;
}

// Where nothing is predicted, rest.
Prior Expected(const RowMotion* predicted) {
  constexpr double kRest = 1e-3;  // rad/s, m/s
  Prior out = Bounds();
  PoseCovariance of_twist = PoseCovariance::Identity() / (kRest * kRest);
  if (predicted != nullptr) {
    const PoseCovariance covariance = predicted->covariance.topLeftCorner<6, 6>();
    of_twist = covariance.ldlt().solve(PoseCovariance::Identity());
    out.mean = MotionOf(*predicted);
  }
  const PoseCovariance with_bounds = out.information.topLeftCorner<6, 6>() + of_twist;
  out.mean.head<6>() = with_bounds.ldlt().solve(of_twist * out.mean.head<6>()).eval();
  out.information.topLeftCorner<6, 6>() = with_bounds;
  return out;
}

struct Normals {
  Information hessian = Information::Zero();
  Step gradient = Step::Zero();
  double squares = 0, rows = 0;
};

struct LinearTag {
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, kUnknowns> jacobian;
};

// A local minimum.
struct Fit {
  RowMotion motion;
  double squares = 0;  // the prior's included
  double typical = 1;  // of one coordinate, in units of what its deviation lets expect
};

// Motions by the tags of one image.
class RowFits {
 public:
  RowFits(const EstimatorSetup& setup, double corner_sigma_px,
          const std::vector<TagDetection>& tags)
      : setup_(setup) {
    seen_.reserve(tags.size());
    for (const TagDetection& tag : tags) {
      const Eigen::LLT<Matrix8> llt(CornerCovariance(setup, tag, corner_sigma_px));
      seen_.push_back({tag, setup.CameraOf(tag.camera), llt.matrixL().solve(Matrix8::Identity())});
    }
  }

  std::optional<Fit> From(const RowMotion& start, const Prior& prior) const;

 private:
  using Matrix8 = Eigen::Matrix<double, 8, 8>;
  struct Seen {
    TagDetection tag;
    MountedCamera by;
    Matrix8 whitener;
  };
  bool LineariseTag(const Seen& seen, const RowMotion& motion, LinearTag* out) const;
  std::optional<Normals> Linearise(const RowMotion& motion) const;

  const EstimatorSetup& setup_;
  std::vector<Seen> seen_;
};

// Whitened; false where a corner is behind the camera.
bool RowFits::LineariseTag(const Seen& seen, const RowMotion& motion, LinearTag* out) const {
  const auto& corners = setup_.map.CornersInWorld(seen.tag.id);
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> by_step;
  Eigen::Matrix<double, 8, 1> after_s;
  for (size_t c = 0; c < 4; ++c) {
    const auto row = 2 * static_cast<Eigen::Index>(c);
    const double s = seen.by.line_time_s * seen.tag.corners[c].y();
    Eigen::Vector2d pixel;
    Eigen::Matrix<double, 2, 6> of_corner;
    if (!ProjectFrom(seen.by, motion.After(s), corners[c], &pixel, &of_corner)) return false;
    residual.segment<2>(row) = pixel - seen.tag.corners[c];
    by_step.middleRows<2>(row) = of_corner;
    after_s.segment<2>(row).setConstant(s);
  }
  out->residual.noalias() = seen.whitener * residual;
  out->jacobian.leftCols<6>().noalias() = seen.whitener * by_step;
  by_step = after_s.asDiagonal() * by_step;
  out->jacobian.middleCols<6>(6).noalias() = seen.whitener * by_step;
  by_step = after_s.asDiagonal() * by_step;
  out->jacobian.rightCols<6>().noalias() = seen.whitener * by_step;
  return true;
}

// nullopt where a corner cannot be seen from there.
std::optional<Normals> RowFits::Linearise(const RowMotion& motion) const {
  constexpr double kMedianChi2Of8 = 7.344;
  std::vector<LinearTag> linear(seen_.size());
  std::vector<double> norms;
  norms.reserve(seen_.size());
  for (size_t i = 0; i < seen_.size(); ++i) {
    if (!LineariseTag(seen_[i], motion, &linear[i])) return std::nullopt;
    norms.push_back(linear[i].residual.squaredNorm());
  }
  const double typical = std::max(1.0, Quantile(norms, 0.5) / kMedianChi2Of8);
  const double delta = HuberDelta(setup_.options.robust_scale, 8) * std::sqrt(typical);
  Normals out;
  for (const LinearTag& tag : linear) {
    const double norm = tag.residual.norm(), weight = norm > delta ? delta / norm : 1;
    out.squares += weight * tag.residual.squaredNorm();
    out.rows += 8 * weight;
    out.hessian.noalias() += weight * tag.jacobian.transpose() * tag.jacobian;
    out.gradient.noalias() += weight * tag.jacobian.transpose() * tag.residual;
  }
  return out;
}

std::optional<Fit> RowFits::From(const RowMotion& start, const Prior& prior) const {
  constexpr int kMostIterations = 10;
  constexpr double kSettled = 1e-6;  // of a squared step in standard deviations
  constexpr double kKnownRows = 8;   // of the deviation, beside what the tags show of it
  Fit out;
  out.motion = start;
  std::optional<Normals> normals;
  Eigen::LDLT<Information> factor;
  for (int i = 0; i < kMostIterations; ++i) {
    normals = Linearise(out.motion);
    if (!normals) return std::nullopt;
    normals->hessian.bottomRightCorner<12, 12>() += prior.information;
    normals->gradient.tail<12>() += prior.Gradient(MotionOf(out.motion));
    factor.compute(normals->hessian);
    const Step step = -factor.solve(normals->gradient);
    if (!step.allFinite()) return std::nullopt;
    out.motion.at_stamp = Retract(out.motion.at_stamp, step.head<6>());
    out.motion.by_s += step.segment<6>(6);
    out.motion.by_s2 += step.tail<6>();
    if (step.dot(normals->hessian * step) < kSettled) break;
  }
  const double free = std::max(0.0, normals->rows - kTold);
  out.squares = normals->squares + prior.Cost(MotionOf(out.motion));
  out.typical = (normals->squares + kKnownRows) / (free + kKnownRows);
  const Information covariance = factor.solve(Information::Identity());
  out.motion.covariance = out.typical * covariance.bottomRightCorner<12, 12>();
  if (!out.motion.covariance.allFinite()) return std::nullopt;
  return out;
}

std::vector<RowMotion> StartsOf(const FramePose& found) {
  std::vector<RowMotion> out;
  if (found.status != FramePoseStatus::kOk) return out;
  out.emplace_back().at_stamp = found.world_from_body;
  for (const Pose& pose : found.alternatives) out.emplace_back().at_stamp = pose;
  return out;
}

bool IsExcluded(const std::optional<Fit>& as_expected, const Fit& freely) {
  constexpr double kMostChi2Of6 = 31;  // 4 standard deviations
  return !as_expected || as_expected->squares > freely.squares + kMostChi2Of6 * freely.typical;
}

// The best of the minima, the one next to the prediction, if there is one and it comes first, where
// the tags do not tell which; what the others would have it be is in its covariance.
Fit BestOf(const std::vector<Fit>& fits, bool is_first_near) {
  constexpr double kDecided = 18;  // twice the logarithm of odds
  size_t best = 0;
  for (size_t i = 1; i < fits.size(); ++i) {
    const double gain = is_first_near && best == 0 ? kDecided * fits[0].typical : 0;
    if (fits[i].squares < fits[best].squares - gain) best = i;
  }
  Fit out = fits[best];
  for (const Fit& fit : fits) {
    const Motion apart = MotionOf(fit.motion) - MotionOf(out.motion);
    const double odds = std::exp((out.squares - fit.squares) / (2 * out.typical));
    out.motion.covariance += odds / (1 + odds) * apart * apart.transpose();
  }
  return out;
}

std::vector<TagDetection> OfTheMap(const EstimatorSetup& setup,
                                   const std::vector<TagDetection>& tags) {
  std::vector<TagDetection> out;
  std::copy_if(tags.begin(), tags.end(), std::back_inserter(out),
               [&](const TagDetection& tag) { return setup.map.Find(tag.id) != nullptr; });
  return out;
}

}  // namespace

std::optional<ToldRowMotion> RowMotionOfTags(const EstimatorSetup& setup, double corner_sigma_px,
                                             const std::vector<TagDetection>& all,
                                             const RowMotion* predicted) {
  const std::vector<TagDetection> tags = OfTheMap(setup, all);
  if (tags.empty() || (tags.size() < kTell && predicted == nullptr)) return std::nullopt;
  const RowFits by_tags(setup, corner_sigma_px, tags);
  std::vector<RowMotion> starts;
  if (predicted == nullptr) starts = StartsOf(FindPoseOfTags(setup, tags));
  if (predicted == nullptr && starts.empty()) return std::nullopt;

  const Prior expected = Expected(predicted);
  RowMotion start = predicted != nullptr ? *predicted : starts.front();
  start.by_s = expected.mean.head<6>();
  start.by_s2 = expected.mean.tail<6>();
  const auto as_expected = by_tags.From(start, expected);
  if (tags.size() < kTell) {
    if (!as_expected) return std::nullopt;
    return ToldRowMotion{as_expected->motion, false};
  }
  std::vector<Fit> freely;
  const auto add = [&](const RowMotion& from) {
    if (auto fit = by_tags.From(from, Bounds())) freely.push_back(std::move(*fit));
  };
  if (as_expected) add(as_expected->motion);
  const bool is_near = !freely.empty();
  if (is_near && !IsExcluded(as_expected, freely.front())) {
    return ToldRowMotion{as_expected->motion, false};
  }
  if (predicted != nullptr) starts = StartsOf(FindPoseOfTags(setup, tags));
  for (const RowMotion& other : starts) add(other);
  if (freely.empty()) return std::nullopt;
  return ToldRowMotion{BestOf(freely, is_near).motion, true};
}

}  // namespace tagtwist::internal
