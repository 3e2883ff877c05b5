#include "estimator/rig/rig_pose.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "frontend/geometry/tag_outline.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// A pose of the body and the tags that it explains, in order.
struct BodyCandidate {
  Pose world_from_body;
  std::vector<size_t> tags;
  double squared_error_px2 = 0;  // of their corners
};

bool IsBetter(const BodyCandidate& a, const BodyCandidate& b) {
  if (a.tags.size() != b.tags.size()) return a.tags.size() > b.tags.size();
  return a.squared_error_px2 < b.squared_error_px2;
}

std::vector<int> CamerasOf(const std::vector<TagDetection>& tags) {
  std::vector<int> out;
  out.reserve(tags.size());
  for (const TagDetection& tag : tags) out.push_back(tag.camera);
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

bool AreApart(const Pose& a, const Pose& b) {
  constexpr double kAngleRad = 0.01, kFraction = 0.01;  // of the distance from the world's origin
  const double distance = std::max(a.translation().norm(), b.translation().norm());
  return AngleBetween(a, b) > kAngleRad ||
         (a.translation() - b.translation()).norm() > kFraction * distance;
}

// Costs of the tags of one frame, in pixels.
class TagsOfRig {
 public:
  TagsOfRig(const EstimatorSetup& setup, const std::vector<TagDetection>& tags) {
    costs_.reserve(tags.size());
    sides_px_.reserve(tags.size());
    const FixedCameras cameras(setup);
    for (const TagDetection& tag : tags) {
      costs_.emplace_back(TagObservation{setup.map.CornersInWorld(tag.id), tag.corners,
                                         Eigen::Matrix<double, 8, 8>::Identity()},
                          cameras.Of(tag.camera));
      sides_px_.push_back(MeanSidePx(tag));
    }
  }

  // Least squares over those tags, damped where a step does not lower them.
  BodyCandidate Refine(const Pose& start, const std::vector<size_t>& tags) const;
  // The tags whose corners all lie within the limit of where the pose has them.
  std::vector<size_t> Agreeing(const Pose& pose, double least_px, double fraction_of_side) const;
  // Refined on the tags that agree, first coarsely, then closely.
  BodyCandidate Grow(const Pose& start) const;

 private:
  // Sum of squares; infinite where a corner cannot be seen.
  double Linearise(const Pose& pose, const std::vector<size_t>& tags, Matrix6* hessian,
                   Vector6* gradient) const;

  std::vector<TagReprojection> costs_;
  std::vector<double> sides_px_;
};

double TagsOfRig::Linearise(const Pose& pose, const std::vector<size_t>& tags, Matrix6* hessian,
                            Vector6* gradient) const {
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> by_pose;
  hessian->setZero();
  gradient->setZero();
  double squares = 0;
  for (const size_t i : tags) {
    if (!costs_[i].Linearize(pose.params.data(), &residual, &by_pose)) return HUGE_VAL;
    hessian->noalias() += by_pose.transpose() * by_pose;
    gradient->noalias() += by_pose.transpose() * residual;
    squares += residual.squaredNorm();
  }
  return squares;
}

BodyCandidate TagsOfRig::Refine(const Pose& start, const std::vector<size_t>& tags) const {
  constexpr int kMostIterations = 15;
  constexpr double kLeastGain = 1e-9;  // of the squares
  Matrix6 hessian, next_hessian;
  Vector6 gradient, next_gradient;
  BodyCandidate out{start, tags, Linearise(start, tags, &hessian, &gradient)};
  double damping = 1e-6;
  for (int i = 0; i < kMostIterations && std::isfinite(out.squared_error_px2); ++i) {
    Matrix6 damped = hessian;
    damped.diagonal() *= 1 + damping;
    const Vector6 step = -damped.ldlt().solve(gradient);
    if (!step.allFinite()) break;
    const Pose next = Retract(out.world_from_body, step);
    const double squares = Linearise(next, tags, &next_hessian, &next_gradient);
    if (!(squares < out.squared_error_px2)) {
      damping = std::max(1e-3, 10 * damping);
      continue;
    }
    const bool settled = out.squared_error_px2 - squares < kLeastGain * out.squared_error_px2;
    out.world_from_body = next;
    out.squared_error_px2 = squares;
    hessian = next_hessian;
    gradient = next_gradient;
    damping *= 0.1;
    if (settled) break;
  }
  return out;
}

std::vector<size_t> TagsOfRig::Agreeing(const Pose& pose, double least_px,
                                        double fraction_of_side) const {
  std::vector<size_t> out;
  Eigen::Matrix<double, 8, 1> residual;
  Eigen::Matrix<double, 8, 6> by_pose;
  for (size_t i = 0; i < costs_.size(); ++i) {
    if (!costs_[i].Linearize(pose.params.data(), &residual, &by_pose)) continue;
    const double limit_px = std::max(least_px, fraction_of_side * sides_px_[i]);
    const double worst_px = residual.reshaped(2, 4).colwise().norm().maxCoeff();
    if (worst_px <= limit_px) out.push_back(i);
  }
  return out;
}

BodyCandidate TagsOfRig::Grow(const Pose& start) const {
  constexpr int kRounds = 4;
  constexpr double kCoarse = 4, kCoarseFraction = 0.5;
  const FramePoseOptions limits;
  BodyCandidate out{start, {}, 0};
  for (const bool coarse : {true, false}) {
    for (int round = 0; round < kRounds; ++round) {
      auto tags = Agreeing(out.world_from_body, limits.agree_px * (coarse ? kCoarse : 1),
                           coarse ? kCoarseFraction : limits.agree_fraction);
      if (tags.empty()) return {out.world_from_body, {}, 0};
      if (tags == out.tags) break;
      out = Refine(out.world_from_body, tags);
    }
  }
  return out;
}

// By one camera's tags.
FramePose PoseByOne(const EstimatorSetup& setup, int camera,
                    const std::vector<TagDetection>& tags) {
  const MountedCamera seen_by = setup.CameraOf(camera);
  if (seen_by.mounted_on == MountedOn::kBody) {
    return FindFramePose(tags, setup.map, seen_by.camera, seen_by.cam_from_body);
  }
  FramePose out = FindFramePose(tags, setup.map, seen_by.camera, Pose());
  const auto to_body = [&](Pose* map_from_cam) {
    *map_from_cam = seen_by.BodyOf(Inverse(*map_from_cam));
  };
  to_body(&out.world_from_body);
  for (Pose& other : out.alternatives) to_body(&other);
  return out;
}

// What the cameras say, each by itself.
struct Proposals {
  std::vector<Pose> poses;      // world_from_body
  std::vector<size_t> inliers;  // of any of them
};

Proposals Propose(const EstimatorSetup& setup, const std::vector<TagDetection>& tags) {
  Proposals out;
  for (const int camera : CamerasOf(tags)) {
    std::vector<TagDetection> own;
    std::vector<size_t> place;
    for (size_t i = 0; i < tags.size(); ++i) {
      if (tags[i].camera != camera) continue;
      own.push_back(tags[i]);
      place.push_back(i);
    }
    const FramePose found = PoseByOne(setup, camera, own);
    if (found.status != FramePoseStatus::kOk) continue;
    out.poses.push_back(found.world_from_body);
    out.poses.insert(out.poses.end(), found.alternatives.begin(), found.alternatives.end());
    for (size_t k = 0; k < own.size(); ++k) {
      if (found.tag_inlier[k]) out.inliers.push_back(place[k]);
    }
  }
  std::sort(out.inliers.begin(), out.inliers.end());
  return out;
}

// Each proposal refined on what all cameras trust; a camera whose tags are wrong would spoil that,
// so that where not all agree each is also grown from its own.
std::vector<BodyCandidate> Judge(const TagsOfRig& rig, const Proposals& proposals, size_t n_tags) {
  std::vector<BodyCandidate> out;
  const auto keep = [&](BodyCandidate candidate) {
    if (!candidate.tags.empty()) out.push_back(std::move(candidate));
  };
  for (const Pose& pose : proposals.poses) {
    keep(rig.Grow(rig.Refine(pose, proposals.inliers).world_from_body));
    if (!out.empty() && out.back().tags.size() == n_tags) continue;
    keep(rig.Grow(pose));
  }
  return out;
}

// Other poses that the corners leave open.
std::vector<Pose> Open(const BodyCandidate& best, const std::vector<BodyCandidate>& candidates) {
  constexpr double kSigmas = 4;
  const double limit_px = kSigmas * FramePoseOptions().ambiguity_px;
  std::vector<Pose> kept = {best.world_from_body};
  for (const BodyCandidate& candidate : candidates) {
    const bool possible =
        candidate.tags == best.tags
            ? candidate.squared_error_px2 - best.squared_error_px2 < limit_px * limit_px
            : candidate.tags.size() == best.tags.size();
    if (possible && std::all_of(kept.begin(), kept.end(), [&](const Pose& other) {
          return AreApart(candidate.world_from_body, other);
        })) {
      kept.push_back(candidate.world_from_body);
    }
  }
  kept.erase(kept.begin());
  return kept;
}

bool IsUsable(const EstimatorSetup& setup, const TagDetection& tag) {
  return setup.map.Find(tag.id) != nullptr &&
         std::all_of(tag.corners.begin(), tag.corners.end(),
                     [](const Eigen::Vector2d& corner) { return corner.allFinite(); });
}

}  // namespace

FramePose FindPoseOfTags(const EstimatorSetup& setup, const std::vector<TagDetection>& tags) {
  const std::vector<int> cameras = CamerasOf(tags);
  if (cameras.size() < 2) {
    return PoseByOne(setup, cameras.empty() ? 0 : cameras.front(), tags);
  }
  FramePose found;
  found.tag_inlier.assign(tags.size(), false);
  std::vector<TagDetection> usable;
  std::vector<size_t> place;
  for (size_t i = 0; i < tags.size(); ++i) {
    if (!IsUsable(setup, tags[i])) continue;
    usable.push_back(tags[i]);
    place.push_back(i);
  }
  if (usable.empty()) return found;
  found.status = FramePoseStatus::kNoPose;
  const TagsOfRig rig(setup, usable);
  const auto candidates = Judge(rig, Propose(setup, usable), usable.size());
  const auto best = std::min_element(candidates.begin(), candidates.end(), IsBetter);
  if (best == candidates.end()) return found;
  found.status = FramePoseStatus::kOk;
  found.world_from_body = best->world_from_body;
  found.rms_px = std::sqrt(best->squared_error_px2 / (4 * static_cast<double>(best->tags.size())));
  for (const size_t i : best->tags) found.tag_inlier[place[i]] = true;
  found.alternatives = Open(*best, candidates);
  return found;
}

std::optional<Pose> MirroredPoseOf(const EstimatorSetup& setup,
                                   const std::vector<TagDetection>& tags,
                                   const Pose& world_from_body) {
  int most = 0;
  std::ptrdiff_t of_most = 0;
  for (const int camera : CamerasOf(tags)) {
    const auto n = std::count_if(tags.begin(), tags.end(), [camera](const TagDetection& tag) {
      return tag.camera == camera;
    });
    if (n > of_most) most = camera;
    of_most = std::max(of_most, n);
  }
  const MountedCamera seen_by = setup.CameraOf(most);
  if (seen_by.mounted_on == MountedOn::kBody) {
    return MirroredPose(tags, setup.map, seen_by.cam_from_body, world_from_body);
  }
  const auto mirrored =
      MirroredPose(tags, setup.map, Pose(), Inverse(seen_by.CamFromMap(world_from_body)));
  return mirrored ? std::optional<Pose>(seen_by.BodyOf(Inverse(*mirrored))) : std::nullopt;
}

}  // namespace tagtwist::internal
