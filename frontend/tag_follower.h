#pragma once
#include <opencv2/core/mat.hpp>
#include <optional>
#include <vector>

#include "frontend/corner_refiner.h"
#include "frontend/detection_policy.h"
#include "frontend/guided_detector.h"
#include "frontend/tag_detector.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist {

/// The usable tags of one image after another, refined: where a prediction guides there, and by
/// searching the image where DetectionPolicy says so.
class TagFollower {
 public:
  static Result<TagFollower> Create(const TagMap& map, const Camera& camera,
                                    const Pose& cam_from_body, const TagDetectorOptions& options);

  /// Tags of the next image (8-bit gray; an empty one has none), sorted by id.
  std::vector<TagDetection> Find(const cv::Mat& gray,
                                 const std::optional<PosePrediction>& prediction);

 private:
  TagFollower(const TagMap& map, const Camera& camera, const Pose& cam_from_body,
              const TagDetectorOptions& options, TagDetector full, TagDetector part,
              CornerRefiner refiner);
  std::vector<TagDetection> SearchAll(const cv::Mat& gray);
  std::vector<TagDetection> SearchPart(const cv::Mat& gray, const Eigen::AlignedBox2d& part,
                                       const std::vector<TagDetection>& known) const;

  TagMap map_;
  Camera camera_;
  double border_px_;
  TagDetector full_detector_, part_detector_;
  CornerRefiner refiner_;
  GuidedDetector guided_;
  DetectionPolicy policy_;
};

}  // namespace tagtwist
