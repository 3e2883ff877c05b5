#include "estimator/batch/mirror_stretches.h"

#include <algorithm>
#include <utility>

#include "estimator/start/mirror.h"

namespace tagtwist::internal {
namespace {

// Half a sum of squares that no motion makes up for.
constexpr double kExcluded = 40;

// What a frame's tags say of the other pose.
struct OtherPose {
  bool is_open = false;  // a minimum of its own
  bool passes = false;  // a run goes on here: the mirrored pose is not excluded, or there is no tag
  double angle_rad = 4;  // beyond any
  double cost = 0;       // that it costs more, of whitened corners
  Pose pose;             // where it is open
};

OtherPose MirroredPoseAt(const EstimatorSetup& setup, const NoiseModel& noise,
                         const GraphFrame& frame) {
  OtherPose out;
  out.passes = frame.tags.empty();
  const auto mirror = MirrorOf(setup, noise, frame);
  if (!mirror) return out;
  out.angle_rad = mirror->angle_rad;
  out.passes = frame.leaves_open || mirror->cost < kExcluded;
  return out;
}

// Of the minima that a frame's tags have alone those of the state and of the mirrored one.
OtherPose OpenPose(const EstimatorSetup& setup, const NoiseModel& noise, const GraphFrame& frame) {
  OtherPose out = MirroredPoseAt(setup, noise, frame);
  const auto other = OtherMinimumOf(setup, noise, frame);
  if (!other) return out;
  out.is_open = true;
  out.angle_rad = AngleBetween(frame.state.world_from_body, other->pose);
  out.cost = other->cost;
  out.pose = other->pose;
  return out;
}

// Open frames, and those beside them through which a run goes on.
std::vector<OtherPose> OtherPoses(const EstimatorSetup& setup, const NoiseModel& noise,
                                  const std::vector<GraphFrame>& frames) {
  std::vector<OtherPose> out(frames.size());
  setup.for_ranges(frames.size(), [&](size_t first, size_t last) {
    for (size_t k = first; k < last; ++k) {
      const bool may_be = frames[k].leaves_open && !frames[k].tags.empty();
      if (may_be) out[k] = OpenPose(setup, noise, frames[k]);
    }
  });
  const auto go_on = [&](size_t k, size_t before) {
    if (!out[k].passes && out[before].passes) out[k] = MirroredPoseAt(setup, noise, frames[k]);
  };
  for (size_t k = 1; k < frames.size(); ++k) go_on(k, k - 1);
  for (size_t k = frames.size(); k-- > 1;) go_on(k - 1, k);
  return out;
}

// Whether the state is nearer to the other pose of the frame before than to that frame's own.
bool JumpsAt(const std::vector<GraphFrame>& frames, const std::vector<OtherPose>& others,
             size_t k) {
  if (!others[k - 1].is_open || !others[k].is_open) return false;
  const Pose &here = frames[k].state.world_from_body, &before = frames[k - 1].state.world_from_body;
  return AngleBetween(here, others[k - 1].pose) < AngleBetween(here, before);
}

// First frames of the pieces that may be mirrored each by itself.
std::vector<int> PiecesOf(const FrameRange& run, const std::vector<GraphFrame>& frames,
                          const std::vector<OtherPose>& others) {
  std::vector<int> out = {run.first};
  const auto begin = [&](int k) {
    if (k > out.back() && k <= run.last) out.push_back(k);
  };
  int k = run.first;
  while (k <= run.last) {
    int least = k;  // of a passage through the trough
    const int entry = k;
    while (k <= run.last && others[static_cast<size_t>(k)].angle_rad < kTroughRad) {
      const auto here = static_cast<size_t>(k), best = static_cast<size_t>(least);
      if (others[here].angle_rad < others[best].angle_rad) least = k;
      ++k;
    }
    if (k > entry) {
      begin(least);
      continue;
    }
    if (k > run.first && JumpsAt(frames, others, static_cast<size_t>(k))) begin(k);
    ++k;
  }
  return out;
}

// All stretches of whole pieces that the corners do not exclude.
std::vector<FrameRange> StretchesOf(const FrameRange& run, const std::vector<int>& pieces,
                                    const std::vector<OtherPose>& others) {
  constexpr size_t kMost = 12, kMostPieces = 40;
  std::vector<std::pair<double, FrameRange>> found;
  const size_t n = std::min(pieces.size(), kMostPieces);
  for (size_t i = 0; i < n; ++i) {
    double cost = 0;
    for (size_t j = i; j < n; ++j) {
      const int last = j + 1 < pieces.size() ? pieces[j + 1] - 1 : run.last;
      for (int k = pieces[j]; k <= last; ++k) cost += others[static_cast<size_t>(k)].cost;
      if (cost < kExcluded) found.push_back({cost, {pieces[i], last}});
    }
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  found.resize(std::min(found.size(), kMost));
  std::vector<FrameRange> out;
  out.reserve(found.size());
  for (const auto& [cost, range] : found) out.push_back(range);
  return out;
}

}  // namespace

std::vector<OpenRun> FindOpenRuns(const EstimatorSetup& setup, const NoiseModel& noise,
                                  const std::vector<GraphFrame>& frames) {
  const bool any = std::any_of(frames.begin(), frames.end(),
                               [](const GraphFrame& frame) { return frame.leaves_open; });
  if (!any) return {};
  const std::vector<OtherPose> others = OtherPoses(setup, noise, frames);
  std::vector<OpenRun> out;
  for (size_t k = 0; k < others.size(); ++k) {
    if (!others[k].passes) continue;
    OpenRun run;
    run.frames.first = static_cast<int>(k);
    while (k + 1 < others.size() && others[k + 1].passes) ++k;
    run.frames.last = static_cast<int>(k);
    run.stretches = StretchesOf(run.frames, PiecesOf(run.frames, frames, others), others);
    if (!run.stretches.empty()) out.push_back(std::move(run));
  }
  return out;
}

}  // namespace tagtwist::internal
