#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// A piece of a KLT track: one point of a plane of the map, seen in consecutive images of a camera.
struct TrackSegment {
  int64_t track_id = -1;
  int first_frame = 0;                  // counted from the recording's first frame
  std::vector<Eigen::Vector2d> pixels;  // in first_frame, first_frame + 1, ...
  int camera = 0;                       // of the rig that sees it
  /// Where other cameras' frames lie between: of each pixel how many frames after first_frame.
  std::vector<int> frames_after = {};

  int FramesAfter(size_t view) const {
    return frames_after.empty() ? static_cast<int>(view) : frames_after[view];
  }
  int last_frame() const {
    return frames_after.empty() ? first_frame + static_cast<int>(pixels.size()) - 1
                                : first_frame + frames_after.back();
  }
  void AddView(int frame, const Eigen::Vector2d& pixel);
};

/// Pieces of tracks, of two views or more, and those among them that the solution contradicted.
struct TrackTally {
  size_t used = 0, contradicted = 0;

  /// For the person who runs it, where that is a tenth of them and twenty at least.
  std::optional<std::string> Warning() const;
};
/// Tally without a contradicted one yet.
TrackTally TallyOf(const std::vector<TrackSegment>& segments);

struct TrackSegmentOptions {
  int max_tracks_per_frame = 40;  // where there is no tag
  int segment_frames = 6;         // >= 2
};

/// Chooses the tracks that enter the graph and cuts them into short pieces, each with a point of
/// its own. A drifting track is not one point for ever, and short pieces keep the normal equations
/// banded. Every view belongs to one piece, so nothing is counted twice. Lengths are staggered by
/// track, so that some pieces span every boundary.
/// Pieces begin where tags are few: seven fewer for every tag in view, which says more and is not
/// bent by drift. A piece begins with its track's view in the frame before, so that it ties the
/// first frame without tags to the last one with them.
class TrackSegmenter {
 public:
  explicit TrackSegmenter(const TrackSegmentOptions& options) : options_(options) {}

  /// Takes the next frame's tracks (those off the tags count), sorted by id: they go on with open
  /// segments or begin new ones. The frame is of these cameras of a rig; what others saw stays
  /// open.
  void Add(const std::vector<TrackObservation>& tracks, int n_tags,
           const std::vector<int>& cameras = {});

  const std::vector<TrackSegment>& segments() const { return segments_; }
  /// Empties those segments whose flag is set; their tracks may begin new ones.
  void Reject(const std::vector<bool>& rejected);
  /// Forgets the segments that begin before `first_frame`.
  void DropBefore(int first_frame);
  /// Counts of the segments that were forgotten or emptied.
  const TrackTally& tally() const { return tally_; }

 private:
  // A track's view in its camera's image before.
  struct View {
    int frame = 0, camera = 0;
    Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  };
  void Begin(const TrackObservation& track, int frame);

  TrackSegmentOptions options_;
  int next_frame_ = 0;
  TrackTally tally_;
  std::vector<TrackSegment> segments_;
  std::map<int64_t, size_t> open_;  // track -> its growing segment
  std::map<int64_t, View> unused_;  // views of each camera's last frame that are in no segment
  std::map<int, int> last_frames_;  // of each camera
};

/// So many tags in view leave no room for a track that begins.
int TagsThatReplaceTracks(int max_tracks_per_frame);

}  // namespace tagtwist::internal
