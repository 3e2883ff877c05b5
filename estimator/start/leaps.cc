#include "estimator/start/leaps.h"

#include <cmath>
#include <cstddef>

#include "estimator/graph/noise_model.h"
#include "estimator/graph/pose_bound.h"
#include "estimator/rig/rig_pose.h"

namespace tagtwist::internal {
namespace {

constexpr double kFastestMps = 10, kFastestRadps = 20;

// What a pose may be off.
struct Slack {
  double m, rad;
};
constexpr Slack kSmall{0.02, 0.1};  // of poses from single frames

bool CanGo(const Pose& from, const Pose& to, double dt_s, const Slack& slack) {
  return (to.translation() - from.translation()).norm() < slack.m + kFastestMps * dt_s &&
         AngleBetween(from, to) < slack.rad + kFastestRadps * dt_s;
}

bool CanGo(const GraphFrame& from, const GraphFrame& to, const Slack& slack = kSmall) {
  return CanGo(from.state.world_from_body, to.state.world_from_body, ToSeconds(to.t_ns - from.t_ns),
               slack);
}

// Of a frame's tags; nullopt where they do not fix a pose.
std::optional<Slack> SlackOf(const EstimatorSetup& setup, const GraphFrame& frame) {
  constexpr double kLeapSigmas = 6;
  const auto bound =
      PoseBound(setup, NoiseModel().corner_sigma_px, frame.state.world_from_body, frame.tags);
  if (!bound) return std::nullopt;
  return Slack{kSmall.m + kLeapSigmas * std::sqrt(bound->diagonal().tail<3>().sum()),
               kSmall.rad + kLeapSigmas * std::sqrt(bound->diagonal().head<3>().sum())};
}

}  // namespace

bool IsWithinReach(const Pose& from, const Pose& to, double dt_s) {
  return CanGo(from, to, dt_s, kSmall);
}

std::vector<bool> Leaps(const EstimatorSetup& setup, const std::vector<GraphFrame>& frames) {
  std::vector<size_t> seen;
  for (size_t i = 0; i < frames.size(); ++i) {
    if (!frames[i].tags.empty()) seen.push_back(i);
  }
  std::vector<bool> out(frames.size(), false);
  for (size_t k = 1; k + 1 < seen.size(); ++k) {
    const GraphFrame &before = frames[seen[k - 1]], &here = frames[seen[k]],
                     &after = frames[seen[k + 1]];
    if (here.tags.size() > 1) continue;
    const auto slack = SlackOf(setup, here);
    if (!slack || CanGo(before, here, *slack) || CanGo(here, after, *slack)) continue;
    const auto mirrored = MirroredPoseOf(setup, here.tags, here.state.world_from_body);
    GraphFrame other = here;
    if (mirrored) other.state.world_from_body = *mirrored;
    if (CanGo(before, other, *slack) || CanGo(other, after, *slack)) continue;
    out[seen[k]] = CanGo(before, after);
  }
  return out;
}

bool DropBeyondReach(std::vector<GraphFrame>* frames) {
  constexpr size_t kOften = 50;  // one in so many frames
  size_t n_seen = 0;
  std::vector<GraphFrame*> beyond;
  for (GraphFrame& frame : *frames) {
    if (!frame.tags.empty()) ++n_seen;
    const Twist& twist = frame.state.twist;
    const bool is_fast =
        twist.v_world.norm() > kFastestMps || twist.omega_body.norm() > kFastestRadps;
    if (is_fast && frame.tags.size() == 1) beyond.push_back(&frame);
  }
  if (kOften * beyond.size() > n_seen) return false;
  for (GraphFrame* frame : beyond) frame->tags.clear();
  return !beyond.empty();
}

}  // namespace tagtwist::internal
