#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "frontend/types/body_state.h"
#include "frontend/types/optional_apart.h"

namespace tagtwist {

/// A tag seen in an image. Corners p1..p4 in pixels, pixel centres at integers (the OpenCV
/// convention): bottom-left, bottom-right, top-right, top-left of the tag as printed.
struct TagDetection {
  int id = -1;
  std::array<Eigen::Vector2d, 4> corners;
  /// Covariance of the corners, u1 v1 .. u4 v4 [px^2]; empty: not known, as of all tags of a file.
  OptionalApart<Eigen::Matrix<double, 8, 8>> covariance;
  int camera = 0;  // of the rig (Rig::cameras) that saw it
};

/// A KLT track seen in an image. Ids grow by order of birth and are never used again.
struct TrackObservation {
  int64_t track_id = -1;
  Eigen::Vector2d pixel = Eigen::Vector2d::Zero();
  bool on_tag =
      false;  // inside a tag seen in this frame, which speaks already or, of another body, moves
  /// Of a track that is told for the first time, but began in the frame before: where it was there.
  std::optional<Eigen::Vector2d> pixel_before = {};
  int camera = 0;  // of the rig (Rig::cameras) that sees it; "before" is that camera's image before
};

/// What the seed report's closed form says of one frame, body in W; empty where it has no answer
/// (no tag; no previous frame; too few points).
struct ClosedForm {
  std::optional<Pose> world_from_body;  // homography, DLT + SVD
  std::optional<Twist> twist_plain;     // least squares over all flow
  std::optional<Twist> twist_ransac;    // refit on the inliers of the 3-point RANSAC
  std::optional<Twist> twist_low_pass;  // the RANSAC twist through the low-pass: the full method
};

/// All that the frontend says of one frame.
struct FrameMeasurements {
  int64_t t_ns = 0;
  std::vector<TagDetection> tags;        // all in the map, each id at most once a camera
  std::vector<TrackObservation> tracks;  // sorted by track_id
  ClosedForm closed_form;
  bool cut_short = false;             // a deadline came before all was measured
  std::vector<int> doubled_ids = {};  // of the map, detected at two places at once
  std::vector<int> cameras = {};      // of a rig those whose images were tracked; empty: the first
  /// Cameras whose image is byte for byte the one that they gave before.
  std::vector<int> same_image = {};
};

}  // namespace tagtwist
