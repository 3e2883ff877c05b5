#include "estimator/batch/batch_audit.h"

#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <utility>

#include "estimator/graph/reprojection.h"
#include "estimator/result/rig_tally.h"

namespace tagtwist::internal {

TagAudit AuditTags(const EstimatorSetup& setup, const SolvedFrames& solved,
                   const TagsByFrame& refused, Estimate* out) {
  TagAudit audit;
  RigTally tally(setup);
  for (size_t i = 0; i < solved.frames.size(); ++i) {
    const GraphFrame& frame = solved.frames[i];
    std::vector<TagDetection> seen = solved.measurements[i].tags;
    const auto of_frame = refused.find(i);
    if (of_frame != refused.end()) {
      seen.insert(seen.end(), of_frame->second.begin(), of_frame->second.end());
    }
    audit.Add(setup, frame, seen);
    tally.AddSeen(seen);
    if (solved.state_of_frame[i] < 0) continue;
    const std::vector<double> errors = ReprojectionErrors(setup, frame);
    out->reprojection_px.insert(out->reprojection_px.end(), errors.begin(), errors.end());
    tally.AddSolved(setup, frame);
  }
  out->reprojection = tally.Errors();
  out->cameras = tally.Shares();
  return audit;
}

std::vector<DoubledTags> WaysWithoutTwins(const EstimatorSetup& setup, const SolvedFrames& solved,
                                          const DoubledTags& doubled) {
  constexpr size_t kMostRivals = 3;
  DoubledTags judged = doubled;
  judged.ForgetSolved();
  std::set<int> all_used;
  std::map<int, std::map<int, int>> rivals;  // of an id seen elsewhere: those used then, in frames
  for (size_t i = 0; i < solved.frames.size(); ++i) {
    if (solved.state_of_frame[i] < 0) continue;
    const GraphFrame& frame = solved.frames[i];
    std::vector<int> used;
    for (const TagDetection& tag : frame.tags) {
      if (std::count(used.begin(), used.end(), tag.id) == 0) used.push_back(tag.id);
    }
    all_used.insert(used.begin(), used.end());
    const auto elsewhere = TagsElsewhere(setup, frame, solved.measurements[i].tags);
    for (const TagElsewhere& tag : elsewhere) {
      for (const int id : used) ++rivals[tag.id][id];
    }
    judged.AddSolved(used, elsewhere);
  }
  DoubledTags otherwise = doubled;
  size_t others = 0;
  bool is_used = false;
  for (const auto& [id, used_then] : rivals) {
    if (!judged.IsLeftOut(id) || doubled.IsLeftOut(id)) continue;
    is_used = is_used || all_used.count(id) > 0;
    for (const auto& [rival, frames] : used_then) otherwise.LeaveOut(rival, frames);
    others += used_then.size();
  }
  if (!is_used) return {};
  std::vector<DoubledTags> out{std::move(judged)};
  if (others > 0 && others <= kMostRivals) out.push_back(std::move(otherwise));
  return out;
}

double LargestJolt(const std::vector<FrameEstimate>& frames) {
  double out = 0;
  const FrameEstimate* before = nullptr;
  std::optional<Eigen::Vector3d> v_before;
  for (const FrameEstimate& frame : frames) {
    if (frame.n_tags == 0) continue;
    if (before != nullptr) {
      const Eigen::Vector3d v = (frame.state.world_from_body.translation() -
                                 before->state.world_from_body.translation()) /
                                ToSeconds(frame.t_ns - before->t_ns);
      if (v_before) out = std::max(out, (v - *v_before).norm());
      v_before = v;
    }
    before = &frame;
  }
  return out;
}

}  // namespace tagtwist::internal
