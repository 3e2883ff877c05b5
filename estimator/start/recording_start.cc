#include "estimator/start/recording_start.h"

#include <algorithm>
#include <utility>

#include "estimator/rig/rig_pose.h"
#include "estimator/start/leaps.h"
#include "estimator/start/pose_path.h"

namespace tagtwist::internal {
namespace {

Pose Interpolate(const Pose& a, const Pose& b, double fraction) {
  return Retract(a, fraction * Difference(b, a));
}

// Indices of the frames that have a pose of their own; the poses are written into the frames.
std::vector<size_t> StartPoses(const EstimatorSetup& setup,
                               const std::vector<FrameMeasurements>& measurements,
                               std::vector<GraphFrame>* frames) {
  std::vector<PoseChoice> choices(measurements.size());
  setup.for_ranges(choices.size(), [&](size_t first, size_t last) {
    for (size_t i = first; i < last; ++i) {
      const FrameMeasurements& m = measurements[i];
      const FramePose found = FindPoseOfTags(setup, m.tags);
      choices[i] = {m.t_ns, AgreeingTags(m.tags, found), {}};
      if (found.status != FramePoseStatus::kOk) continue;
      choices[i].poses = found.alternatives;
      choices[i].poses.insert(choices[i].poses.begin(), found.world_from_body);
    }
  });
  const std::vector<std::optional<Pose>> path = LikeliestPath(setup, choices);
  std::vector<size_t> known;
  for (size_t i = 0; i < path.size(); ++i) {
    if (!path[i]) continue;
    (*frames)[i].state.world_from_body = *path[i];
    (*frames)[i].tags = std::move(choices[i].tags);
    (*frames)[i].leaves_open = choices[i].poses.size() > 1;
    known.push_back(i);
  }
  return known;
}

void FillPosesBetween(const std::vector<size_t>& known, std::vector<GraphFrame>* frames) {
  for (size_t i = 0; i < known.front(); ++i) {
    (*frames)[i].state.world_from_body = (*frames)[known.front()].state.world_from_body;
  }
  for (size_t i = known.back() + 1; i < frames->size(); ++i) {
    (*frames)[i].state.world_from_body = (*frames)[known.back()].state.world_from_body;
  }
  for (size_t k = 0; k + 1 < known.size(); ++k) {
    const GraphFrame &a = (*frames)[known[k]], &b = (*frames)[known[k + 1]];
    for (size_t i = known[k] + 1; i < known[k + 1]; ++i) {
      GraphFrame& frame = (*frames)[i];
      const double fraction =
          static_cast<double>(frame.t_ns - a.t_ns) / static_cast<double>(b.t_ns - a.t_ns);
      frame.state.world_from_body =
          Interpolate(a.state.world_from_body, b.state.world_from_body, fraction);
    }
  }
}

void StartTwists(const std::vector<FrameMeasurements>& measurements,
                 std::vector<GraphFrame>* frames) {
  for (size_t i = 0; i < frames->size(); ++i) {
    GraphFrame& frame = (*frames)[i];
    if (measurements[i].closed_form.twist_ransac) {
      frame.state.twist = *measurements[i].closed_form.twist_ransac;
    } else if (frames->size() > 1) {
      const size_t first = i + 1 < frames->size() ? i : i - 1;
      const GraphFrame &a = (*frames)[first], &b = (*frames)[first + 1];
      frame.state.twist = TwistBetween(a.state.world_from_body, b.state.world_from_body,
                                       ToSeconds(b.t_ns - a.t_ns));
    }
  }
}

}  // namespace

BodyState Predict(const BodyState& state, double dt_s) {
  PoseStep way;
  way << dt_s * state.twist.omega_body, dt_s * state.twist.v_world;
  return {Retract(state.world_from_body, way), state.twist};
}

std::optional<Pose> ChoosePose(const FramePose& found, const Pose* expected) {
  if (found.status != FramePoseStatus::kOk) return std::nullopt;
  Pose best = found.world_from_body;
  if (expected == nullptr) return best;
  for (const Pose& other : found.alternatives) {
    if (AngleBetween(other, *expected) < AngleBetween(best, *expected)) best = other;
  }
  return best;
}

std::vector<TagDetection> AgreeingTags(const std::vector<TagDetection>& tags,
                                       const FramePose& found) {
  std::vector<TagDetection> out;
  for (size_t i = 0; i < tags.size(); ++i) {
    if (i < found.tag_inlier.size() && found.tag_inlier[i]) out.push_back(tags[i]);
  }
  return out;
}

Result<std::vector<GraphFrame>> StartFrames(const EstimatorSetup& setup,
                                            const std::vector<FrameMeasurements>& measurements) {
  std::vector<GraphFrame> frames(measurements.size());
  for (size_t i = 0; i < frames.size(); ++i) frames[i].t_ns = measurements[i].t_ns;
  std::vector<size_t> known = StartPoses(setup, measurements, &frames);
  const std::vector<bool> leaps = Leaps(setup, frames);
  for (size_t i = 0; i < frames.size(); ++i) {
    if (leaps[i]) frames[i].tags.clear();
  }
  known.erase(std::remove_if(known.begin(), known.end(), [&](size_t i) { return leaps[i]; }),
              known.end());
  if (known.empty()) return Error{"no frame has a tag of the map that gives a pose"};
  FillPosesBetween(known, &frames);
  StartTwists(measurements, &frames);
  return frames;
}

}  // namespace tagtwist::internal
