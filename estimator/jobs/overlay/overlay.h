#pragma once
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <string>
#include <vector>

#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/pose.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// What is drawn on one image.
struct OverlayFrame {
  cv::Mat image;  // 8-bit gray, of the camera's size; empty: drawn on black
  std::vector<TagDetection> tags;
  std::vector<TrackObservation> tracks;
  std::optional<Pose> cam_from_world;  // the map is drawn from there
  std::string text;                    // a line below the image, Latin letters
};

/// Draws frames of a recording one after the other: tags as they were seen (green, with their ids
/// and a dot at p1), the map's tags where the pose puts them (orange), tracks from where they were
/// in the frame before (blue), and a line of text below. Small images are enlarged.
class OverlayDrawing {
 public:
  OverlayDrawing(const Camera& camera, const TagMap& map);

  /// 8-bit BGR; width and height are even, and the same for all frames.
  cv::Mat Draw(const OverlayFrame& frame);
  /// Enlargement: pixel u of the image is drawn around scale() * (u + 0.5) - 0.5.
  int scale() const { return scale_; }

 private:
  cv::Point ToCanvas(const Eigen::Vector2d& pixel) const;
  void DrawMap(const Pose& cam_from_world, cv::Mat* canvas) const;
  void DrawTags(const std::vector<TagDetection>& tags, cv::Mat* canvas) const;
  void DrawTracks(const std::vector<TrackObservation>& tracks, cv::Mat* canvas);

  Camera camera_;
  TagMap map_;
  int scale_ = 1;
  std::map<int64_t, Eigen::Vector2d> before_;  // where the tracks were
};

}  // namespace tagtwist::internal
