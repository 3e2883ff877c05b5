#include "estimator/graph/track_segments.h"

#include <algorithm>
#include <utility>

#include "frontend/base/format_text.h"

namespace tagtwist::internal {
namespace {

// Tracks that a tag makes up for.
constexpr int kTracksPerTag = 7;

// A scattered order of ids: neighbours in the image, born together, do not stay together.
uint64_t Scatter(int64_t id) { return static_cast<uint64_t>(id) * 0x9E3779B97F4A7C15ULL; }

// Frames after which a segment is cut: the first of a track is shorter, by its id.
int SegmentLimit(const TrackSegment& segment, int segment_frames) {
  const int64_t stagger = static_cast<int64_t>((Scatter(segment.track_id) >> 32) & 0x7FFFFFFF);
  const int64_t phase = (segment.first_frame + stagger) % segment_frames;
  return std::max(2, segment_frames - static_cast<int>(phase));
}

}  // namespace

int TagsThatReplaceTracks(int max_tracks_per_frame) {
  return std::max(1, (max_tracks_per_frame + kTracksPerTag - 1) / kTracksPerTag);
}

std::optional<std::string> TrackTally::Warning() const {
  constexpr size_t kLeast = 20, kOneIn = 10;
  if (contradicted < kLeast || kOneIn * contradicted < used) return std::nullopt;
  return Format(
      "%zu of %zu pieces of tracked points did not lie still on the tags' surface, and were left "
      "out: something moves in view, or stands out of it",
      contradicted, used);
}

TrackTally TallyOf(const std::vector<TrackSegment>& segments) {
  TrackTally out;
  for (const TrackSegment& segment : segments) out.used += segment.pixels.size() > 1 ? 1 : 0;
  return out;
}

void TrackSegment::AddView(int frame, const Eigen::Vector2d& pixel) {
  const int after = frame - first_frame, next = static_cast<int>(pixels.size());
  if (after != next && frames_after.empty()) {
    for (int i = 0; i < next; ++i) frames_after.push_back(i);
  }
  if (after != next || !frames_after.empty()) frames_after.push_back(after);
  pixels.push_back(pixel);
}

void TrackSegmenter::Add(const std::vector<TrackObservation>& tracks, int n_tags,
                         const std::vector<int>& cameras) {
  const int frame = next_frame_++;
  // A view of a camera that has no image now may still be gone on with, as long as pieces are.
  const auto stays = [&](int camera, int first_frame) {
    return !cameras.empty() && frame - first_frame < options_.segment_frames - 1 &&
           std::find(cameras.begin(), cameras.end(), camera) == cameras.end();
  };
  const int budget = options_.max_tracks_per_frame - kTracksPerTag * n_tags;
  std::map<int64_t, size_t> still_open;
  for (const auto& [id, s] : open_) {
    if (stays(segments_[s].camera, segments_[s].first_frame)) still_open.emplace(id, s);
  }
  std::vector<const TrackObservation*> fresh;
  int n_used = 0;
  for (const TrackObservation& track : tracks) {
    if (track.on_tag) continue;
    const auto it = open_.find(track.track_id);
    if (it == open_.end()) {
      fresh.push_back(&track);
      continue;
    }
    TrackSegment& segment = segments_[it->second];
    segment.AddView(frame, track.pixel);
    ++n_used;
    // A full one ends here; its track may begin another in the next frame.
    if (frame - segment.first_frame + 1 < SegmentLimit(segment, options_.segment_frames)) {
      still_open.insert(*it);
    }
  }
  open_ = std::move(still_open);
  std::sort(fresh.begin(), fresh.end(), [](const auto* a, const auto* b) {
    return Scatter(a->track_id) < Scatter(b->track_id);
  });
  std::map<int64_t, View> unused;
  for (const auto& [id, view] : unused_) {
    if (stays(view.camera, view.frame)) unused.emplace(id, view);
  }
  for (const TrackObservation* track : fresh) {
    if (n_used < budget) {
      Begin(*track, frame);
      ++n_used;
    } else {
      unused[track->track_id] = {frame, track->camera, track->pixel};
    }
  }
  unused_ = std::move(unused);
  if (cameras.empty()) last_frames_[0] = frame;
  for (const int camera : cameras) last_frames_[camera] = frame;
}

void TrackSegmenter::Begin(const TrackObservation& track, int frame) {
  std::optional<View> before;
  if (const auto unused = unused_.find(track.track_id); unused != unused_.end()) {
    before = unused->second;
  } else if (const auto last = last_frames_.find(track.camera);
             track.pixel_before && last != last_frames_.end() &&
             frame - last->second < options_.segment_frames) {
    before = View{last->second, track.camera, *track.pixel_before};
  }
  TrackSegment segment;
  segment.track_id = track.track_id;
  segment.camera = track.camera;
  segment.first_frame = before ? before->frame : frame;
  if (before) segment.AddView(before->frame, before->pixel);
  segment.AddView(frame, track.pixel);
  open_.emplace(track.track_id, segments_.size());
  segments_.push_back(std::move(segment));
}

void TrackSegmenter::Reject(const std::vector<bool>& rejected) {
  for (size_t i = 0; i < rejected.size(); ++i) {
    if (!rejected[i]) continue;
    ++tally_.used;
    ++tally_.contradicted;
    segments_[i].pixels.clear();
    segments_[i].frames_after.clear();
    const auto it = open_.find(segments_[i].track_id);
    if (it != open_.end() && it->second == i) open_.erase(it);
  }
}

void TrackSegmenter::DropBefore(int first_frame) {
  std::vector<TrackSegment> kept;
  std::map<int64_t, size_t> still_open;
  for (size_t i = 0; i < segments_.size(); ++i) {
    if (segments_[i].first_frame < first_frame) {
      tally_.used += segments_[i].pixels.size() > 1 ? 1 : 0;
      continue;
    }
    const auto it = open_.find(segments_[i].track_id);
    if (it != open_.end() && it->second == i) still_open.emplace(it->first, kept.size());
    kept.push_back(std::move(segments_[i]));
  }
  segments_ = std::move(kept);
  open_ = std::move(still_open);
}

}  // namespace tagtwist::internal
