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

namespace {

// Where frames see an id elsewhere than the tags say that they were solved with.
struct Place {
  Eigen::Vector2d shift_m;
  int frames = 0;
};

// What a solution shows of ids: a solution may change from one of two tags that have an id to the
// other and back, so that what counts is how often a place comes again, and not in a row.
class Sightings {
 public:
  void Add(const std::vector<int>& used, const std::vector<TagElsewhere>& elsewhere) {
    if (used.empty()) return;  // nothing but the motion says where they should be
    used_.insert(used.begin(), used.end());
    for (const TagElsewhere& tag : elsewhere) {
      CountPlace(tag);
      for (const int id : used) ++rivals_[tag.id][id];
    }
  }

  // Seen at one place in five frames, where no phantom comes again: by id, in how many.
  std::map<int, int> Doubled() const {
    constexpr int kOften = 5;
    std::map<int, int> out;
    for (const auto& [id, places] : places_) {
      for (const Place& place : places) {
        if (place.frames >= kOften) out[id] = std::max(out[id], place.frames);
      }
    }
    return out;
  }
  bool IsUsed(int id) const { return used_.count(id) > 0; }
  // The tags that frames were solved with that saw it elsewhere, in how many.
  const std::map<int, int>& RivalsOf(int id) const { return rivals_.at(id); }

 private:
  void CountPlace(const TagElsewhere& tag) {
    constexpr size_t kMostPlaces = 100;
    std::vector<Place>& places = places_[tag.id];
    const auto here = std::find_if(places.begin(), places.end(), [&](const Place& place) {
      return (place.shift_m - tag.shift_m).norm() < tag.size_m;
    });
    if (here != places.end()) {
      ++here->frames;
    } else if (places.size() < kMostPlaces) {
      places.push_back({tag.shift_m, 1});
    }
  }

  std::set<int> used_;
  std::map<int, std::vector<Place>> places_;
  std::map<int, std::map<int, int>> rivals_;
};

Sightings SightingsOf(const EstimatorSetup& setup, const SolvedFrames& solved) {
  Sightings out;
  for (size_t i = 0; i < solved.frames.size(); ++i) {
    if (solved.state_of_frame[i] < 0) continue;
    const GraphFrame& frame = solved.frames[i];
    std::vector<int> used;
    for (const TagDetection& tag : frame.tags) {
      if (std::count(used.begin(), used.end(), tag.id) == 0) used.push_back(tag.id);
    }
    out.Add(used, TagsElsewhere(setup, frame, solved.measurements[i].tags));
  }
  return out;
}

}  // namespace

std::vector<DoubledTags> WaysWithoutTwins(const EstimatorSetup& setup, const SolvedFrames& solved,
                                          const DoubledTags& doubled) {
  constexpr size_t kMostRivals = 3, kMostWays = 6;
  const Sightings sightings = SightingsOf(setup, solved);
  std::map<int, int> all, rivals;  // to be left out, each wrong in so many frames
  bool is_used = false, are_rivals = false;
  for (const auto& [id, frames] : sightings.Doubled()) {
    if (doubled.IsLeftOut(id)) continue;
    all[id] = frames;
    is_used = is_used || sightings.IsUsed(id);
  }
  if (!is_used) return {};
  for (const auto& [id, frames] : all) {
    for (const auto& [rival, in_frames] : sightings.RivalsOf(id)) {
      rivals[rival] += in_frames;
      are_rivals = are_rivals || all.count(rival) > 0;
    }
  }
  std::vector<DoubledTags> out;
  const auto leave_out = [&](const std::map<int, int>& ids) {
    DoubledTags without = doubled;
    for (const auto& [id, frames] : ids) without.LeaveOut(id, frames);
    if (out.size() < kMostWays) out.push_back(std::move(without));
  };
  if (!are_rivals || all.size() == 1) leave_out(all);
  if (all.size() > 1) {
    for (const auto& one : all) leave_out({one});
  }
  if (!are_rivals && rivals.size() <= kMostRivals) leave_out(rivals);
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
