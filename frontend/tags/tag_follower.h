#pragma once
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/detection_policy.h"
#include "frontend/tags/guided_detector.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// The usable tags of one image after another, refined: where a prediction guides there, and by
/// searching the image where DetectionPolicy says so.
class TagFollower {
 public:
  static Result<TagFollower> Create(const SetUp& set_up, const TagDetectorOptions& options);

  /// Tags of the next image (8-bit gray; an empty one has none), sorted by id. Where the time may
  /// be up the image is not searched as a whole, but part by part, at least one, and the next image
  /// from there on.
  std::vector<TagDetection> Find(const cv::Mat& gray,
                                 const std::optional<PosePrediction>& prediction,
                                 const TimeUp& time_up = {});
  /// Whether the time was up before the last image was done with.
  bool was_cut_short() const { return was_cut_short_; }
  /// DoubledIds of what was found in the last image.
  const std::vector<int>& doubled_ids() const { return doubled_ids_; }

 private:
  TagFollower(const SetUp& set_up, const TagDetectorOptions& options, TagDetector full,
              TagDetector plain, CornerRefiner refiner);
  std::vector<TagDetection> SearchAll(const cv::Mat& gray, const TimeUp& time_up);
  std::vector<TagDetection> SearchParts(const cv::Mat& gray, const TimeUp& time_up);
  std::vector<TagDetection> SearchPart(const cv::Mat& gray, const Eigen::AlignedBox2d& part,
                                       const std::vector<TagDetection>& known);
  std::vector<TagDetection> Filtered(const std::vector<TagDetection>& tags);

  TagMap map_;
  Camera camera_;
  double border_px_;
  TagDetector full_detector_, plain_detector_;
  CornerRefiner refiner_;
  GuidedDetector guided_;
  DetectionPolicy policy_;
  bool was_cut_short_ = false;
  std::vector<int> doubled_ids_;
};

}  // namespace tagtwist::internal
