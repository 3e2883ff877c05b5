#include "estimator/start/mirror.h"

#include <algorithm>
#include <cmath>

#include "estimator/graph/noise_model.h"
#include "estimator/rig/rig_pose.h"
#include "residuals/tag_reprojection_residual.h"

namespace tagtwist::internal {
namespace {

const Pose& NearestOf(const std::vector<Pose>& poses, const Pose& to) {
  return *std::min_element(poses.begin(), poses.end(), [&](const Pose& a, const Pose& b) {
    return AngleBetween(a, to) < AngleBetween(b, to);
  });
}

// A frame between others follows the nearest one of the range that has a mirrored pose.
void MoveWithNeighbours(const std::vector<std::optional<Pose>>& moves, int first,
                        std::vector<GraphFrame>* frames) {
  const int n = static_cast<int>(moves.size());
  for (int i = 0; i < n; ++i) {
    for (int distance = 0; distance < n; ++distance) {
      const int before = i - distance, after = i + distance;
      const bool by_before = before >= 0 && moves[static_cast<size_t>(before)].has_value();
      const bool by_after = after < n && moves[static_cast<size_t>(after)].has_value();
      if (!by_before && !by_after) continue;
      Pose& pose = (*frames)[static_cast<size_t>(first + i)].state.world_from_body;
      pose = *moves[static_cast<size_t>(by_before ? before : after)] * pose;
      break;
    }
  }
}

}  // namespace

std::optional<double> CornerCost(const EstimatorSetup& setup, const NoiseModel& noise,
                                 const GraphFrame& frame, const Pose& world_from_body) {
  double sum = 0;
  const FixedCameras cameras(setup);
  for (const TagDetection& tag : frame.tags) {
    const TagReprojection residual({setup.map.CornersInWorld(tag.id), tag.corners,
                                    CornerCovariance(setup, tag, noise.corner_sigma_px)},
                                   cameras.Of(tag.camera));
    Eigen::Matrix<double, 8, 1> r;
    if (!residual.Linearize(world_from_body.params.data(), &r, nullptr)) return std::nullopt;
    sum += 0.5 * r.squaredNorm();
  }
  return sum;
}

std::optional<Mirror> MirrorOf(const EstimatorSetup& setup, const NoiseModel& noise,
                               const GraphFrame& frame) {
  const Pose& pose = frame.state.world_from_body;
  const auto mirrored = MirroredPoseOf(setup, frame.tags, pose);
  if (!mirrored) return std::nullopt;
  const auto cost = CornerCost(setup, noise, frame, pose);
  const auto of_mirrored = CornerCost(setup, noise, frame, *mirrored);
  if (!cost || !of_mirrored) return std::nullopt;
  return Mirror{AngleBetween(pose, *mirrored), *of_mirrored - *cost};
}

std::optional<OtherMinimum> OtherMinimumOf(const EstimatorSetup& setup, const NoiseModel& noise,
                                           const GraphFrame& frame) {
  const Pose& here = frame.state.world_from_body;
  const FramePose found = FindPoseOfTags(setup, frame.tags);
  const auto mirrored = MirroredPoseOf(setup, frame.tags, here);
  if (found.status != FramePoseStatus::kOk || !mirrored) return std::nullopt;
  std::vector<Pose> poses = found.alternatives;
  poses.push_back(found.world_from_body);
  const Pose &own = NearestOf(poses, here), &other = NearestOf(poses, *mirrored);
  const auto cost = CornerCost(setup, noise, frame, own);
  const auto of_other = CornerCost(setup, noise, frame, other);
  if (&own == &other || !cost || !of_other) return std::nullopt;
  return OtherMinimum{other, *of_other - *cost};
}

void MirrorFrames(const EstimatorSetup& setup, const FrameRange& range,
                  std::vector<GraphFrame>* frames) {
  std::vector<std::optional<Pose>> moves;  // each in front of its pose
  for (int k = range.first; k <= range.last; ++k) {
    GraphFrame& frame = (*frames)[static_cast<size_t>(k)];
    const Pose& pose = frame.state.world_from_body;
    const auto mirrored =
        frame.tags.empty() ? std::nullopt : MirroredPoseOf(setup, frame.tags, pose);
    moves.push_back(mirrored ? std::optional<Pose>(*mirrored * Inverse(pose)) : std::nullopt);
    frame.acceleration = {};
  }
  MoveWithNeighbours(moves, range.first, frames);
  for (int k = range.first; k <= range.last && range.first < range.last; ++k) {
    const int from = std::min(k, range.last - 1);
    const GraphFrame &a = (*frames)[static_cast<size_t>(from)],
                     &b = (*frames)[static_cast<size_t>(from) + 1];
    (*frames)[static_cast<size_t>(k)].state.twist =
        TwistBetween(a.state.world_from_body, b.state.world_from_body, ToSeconds(b.t_ns - a.t_ns));
  }
}

double MirrorDoubt(const EstimatorSetup& setup, const NoiseModel& noise,
                   const std::vector<GraphFrame>& frames) {
  constexpr double kPart = 0.3, kMost = 30;
  double cost = 0;
  bool any = false;
  for (size_t k = frames.size(); k-- > 0 && cost < kMost;) {
    const auto mirror = MirrorOf(setup, noise, frames[k]);
    if (!mirror) continue;
    cost += mirror->cost;
    any = true;
  }
  return any && cost < kMost ? 1 / (1 + std::exp(kPart * std::max(cost, 0.0))) : 0;
}

void TakeMirrored(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames, size_t frame,
                  double probability, StateCovariance* covariance) {
  if (!(probability > 0)) return;
  const size_t first = frame > 0 ? frame - 1 : 0, n = std::min<size_t>(2, frames.size() - first);
  const auto begin = frames.begin() + static_cast<std::ptrdiff_t>(first);
  std::vector<GraphFrame> beside(begin, begin + static_cast<std::ptrdiff_t>(n));
  MirrorFrames(setup, {0, static_cast<int>(n) - 1}, &beside);
  const BodyState &here = frames[frame].state, &there = beside[frame - first].state;
  const Eigen::Matrix3d turned =
      (there.world_from_body.rotation() * here.world_from_body.rotation().conjugate())
          .toRotationMatrix();
  StateCovariance axes = StateCovariance::Identity();
  axes.block<3, 3>(3, 3) = turned;
  axes.block<3, 3>(6, 6) = turned;
  const StateVector d = Difference(there, here);
  *covariance = (1 - probability) * *covariance +
                probability * (axes * *covariance * axes.transpose() + d * d.transpose());
}

}  // namespace tagtwist::internal
