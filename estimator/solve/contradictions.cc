#include "estimator/solve/contradictions.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "estimator/graph/linear_system.h"
#include "estimator/graph/noise_model.h"

namespace tagtwist::internal {
namespace {

// A tag as one camera sees it: camera and id.
using View = std::pair<int, int>;
View ViewOf(const TagDetection& tag) { return {tag.camera, tag.id}; }

bool Holds(const std::vector<TagDetection>& tags, const View& view) {
  return std::any_of(tags.begin(), tags.end(),
                     [&](const TagDetection& tag) { return ViewOf(tag) == view; });
}

std::set<View> ViewsOf(const std::vector<TagDetection>& tags) {
  std::set<View> out;
  for (const TagDetection& tag : tags) out.insert(ViewOf(tag));
  return out;
}

// Ids of tags that most of the frames that show them do without. Where that are most of several
// ids, it is not the tags: none.
std::set<int> UnreliableTags(const std::vector<const std::vector<TagDetection>*>& seen,
                             const std::vector<GraphFrame>& frames) {
  constexpr int kLeastFrames = 5;
  std::map<int, std::pair<int, int>> seen_and_used;  // frames, by id
  for (size_t i = 0; i < frames.size(); ++i) {
    for (const TagDetection& tag : *seen[i]) ++seen_and_used[tag.id].first;
    for (const TagDetection& tag : frames[i].tags) ++seen_and_used[tag.id].second;
  }
  std::set<int> out;
  size_t judged = 0;
  for (const auto& [id, counts] : seen_and_used) {
    if (counts.first < kLeastFrames) continue;
    ++judged;
    if (2 * counts.second < counts.first) out.insert(id);
  }
  return judged > 2 && 2 * out.size() > judged ? std::set<int>() : out;
}

}  // namespace

std::vector<TagRef> ContradictedTags(const Graph& graph) {
  std::vector<TagRef> out;
  LinearFactor linear;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTag || !LinearizeFactor(graph, factor, &linear)) continue;
    if (linear.weight < kContradictedWeight)
      out.push_back({factor.blocks.front().index, factor.source});
  }
  return out;
}

std::vector<TagRef> ContradictedTags(const QuadraticChain& chain) {
  std::vector<TagRef> out;
  for (int k = 0; k < static_cast<int>(chain.graph().states.size()); ++k) {
    const PoseForm& form = chain.form(k);
    for (size_t i = 0; i < form.factors.size(); ++i) {
      const Factor& factor = chain.graph().factors[form.factors[i]];
      if (factor.kind != FactorKind::kTag) continue;
      if (form.Weight(chain.graph(), i) < kContradictedWeight) out.push_back({k, factor.source});
    }
  }
  return out;
}

void DropTags(std::vector<TagRef> tags, std::vector<GraphFrame>* frames) {
  std::sort(tags.begin(), tags.end(), [](const TagRef& a, const TagRef& b) {
    return a.state != b.state ? a.state > b.state : a.tag > b.tag;  // from the back of each frame
  });
  for (const TagRef& ref : tags) {
    auto& of_frame = (*frames)[static_cast<size_t>(ref.state)].tags;
    of_frame.erase(of_frame.begin() + ref.tag);
  }
}

std::vector<bool> ContradictedSegments(const Graph& graph, size_t n) {
  std::vector<bool> out(n, false);
  LinearFactor linear;
  for (const Factor& factor : graph.factors) {
    if (factor.kind != FactorKind::kTrack || !LinearizeFactor(graph, factor, &linear)) continue;
    if (linear.weight < kContradictedWeight) out[static_cast<size_t>(factor.source)] = true;
  }
  return out;
}

bool AgreesWith(const EstimatorSetup& setup, const NoiseModel& noise, const BodyState& state,
                const TagDetection& tag) {
  constexpr double kSigmas = 5;
  double variance = noise.corner_sigma_px * noise.corner_sigma_px;
  if (tag.covariance) variance += tag.covariance->diagonal().maxCoeff();
  const double limit_px = kSigmas * std::sqrt(variance);
  const MountedCamera seen_by = setup.CameraOf(tag.camera);
  const Pose cam_from_map = seen_by.CamFromMap(state.world_from_body);
  for (size_t c = 0; c < 4; ++c) {
    Eigen::Vector2d pixel;
    const Eigen::Vector3d corner = cam_from_map * setup.map.CornersInWorld(tag.id)[c];
    if (!seen_by.camera.Project(corner, &pixel)) return false;
    if (!((pixel - tag.corners[c]).norm() < limit_px)) return false;
  }
  return true;
}

bool ReviseTags(const EstimatorSetup& setup, const NoiseModel& noise, const Graph& graph,
                const std::vector<const std::vector<TagDetection>*>& seen, bool readmit,
                std::vector<GraphFrame>* frames) {
  std::vector<std::set<View>> before;
  for (const GraphFrame& frame : *frames) before.push_back(ViewsOf(frame.tags));
  const std::vector<TagRef> contradicted = ContradictedTags(graph);
  DropTags(contradicted, frames);
  bool changed = !contradicted.empty();
  const std::set<int> unreliable = UnreliableTags(seen, *frames);
  for (size_t i = 0; i < frames->size(); ++i) {
    GraphFrame& frame = (*frames)[i];
    std::vector<TagDetection> kept;
    kept.reserve(frame.tags.size());
    for (const TagDetection& tag : *seen[i]) {
      const bool again = readmit && before[i].count(ViewOf(tag)) == 0 &&
                         AgreesWith(setup, noise, frame.state, tag);
      if (unreliable.count(tag.id) == 0 && (again || Holds(frame.tags, ViewOf(tag)))) {
        kept.push_back(tag);
        changed = changed || again;
      }
    }
    changed = changed || kept.size() != frame.tags.size();
    frame.tags = std::move(kept);
  }
  return changed;
}

}  // namespace tagtwist::internal
