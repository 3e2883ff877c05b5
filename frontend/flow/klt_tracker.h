#pragma once
#include <cstddef>
#include <cstdint>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "frontend/flow/klt_options.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// FAST corners followed by pyramidal Lucas-Kanade from frame to frame, with a forward-backward
/// check, each over as many frames as it lasts. Where two frames share two tags or more, their
/// homography says where the points are to be expected, so large motion is followed too; without
/// it a second search begins where the image as a whole moved to, and where most of the points that
/// should be in view are not found again, all tracks end. While tags are enough, only the image is
/// kept: the first one without enough shows tracks that began in the image before it.
class KltTracker {
 public:
  explicit KltTracker(const KltOptions& options)
      : options_(options), fast_threshold_(options.fast_threshold) {}

  /// Tracks seen in the next image (8-bit gray), sorted by id: those that were followed into it and
  /// those that begin in it. An image that is empty or of another type ends all tracks, one of
  /// another size too. `tags` are this image's; they set on_tag and the prediction. What other
  /// cameras of a rig see at the same time counts where tags are enough. Tags of bodies that move
  /// set on_tag alone.
  std::vector<TrackObservation> Track(const cv::Mat& image, const std::vector<TagDetection>& tags,
                                      size_t tags_elsewhere = 0,
                                      const std::vector<TagDetection>& moving_tags = {});

 private:
  // What became of the tracks, and of how many that what most of them did leaves in view.
  struct Step {
    std::vector<TrackObservation> followed;
    double share = 0;
  };
  void BeginInKeptImage();
  Step FollowFrom(const std::vector<cv::Mat>& pyramid, std::vector<cv::Point2f> ahead,
                  int levels) const;
  void Follow(const std::vector<cv::Mat>& pyramid, const std::vector<TagDetection>& tags);
  void Replenish(const cv::Mat& image);
  void MarkOnTag(const std::vector<TagDetection>& tags,
                 const std::vector<TagDetection>& moving_tags);

  KltOptions options_;
  int fast_threshold_;                    // adapted to the images
  std::vector<cv::Mat> pyramid_;          // of the last image, with derivatives; empty: no image
  cv::Mat kept_;                          // the last image, where its tags were enough
  std::vector<TagDetection> tags_;        // of the last image
  std::vector<TrackObservation> tracks_;  // in the last image, sorted by id
  int64_t next_id_ = 0;
};

}  // namespace tagtwist::internal
