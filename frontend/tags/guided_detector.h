#pragma once
#include <cstddef>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <unordered_map>
#include <vector>

#include "frontend/base/time_up.h"
#include "frontend/pattern/corner_refiner.h"
#include "frontend/types/body_state.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Where the body is expected to be when an image is taken.
struct PosePrediction {
  Pose world_from_body;
  PoseCovariance covariance = PoseCovariance::Zero();  // error state of BodyState, its pose
  double corner_sigma_px = 0;  // of a corner's coordinate, beyond what its fit says: lens, map
};

/// A tag of the map as a pose predicts it.
struct ExpectedTag {
  TagDetection tag;                       // covariance: of the prediction
  Eigen::Matrix<double, 8, 6> d_corners;  // u1 v1 .. u4 v4 by the pose's error state
  double sigma_px = 0;                    // of the corner that is known worst
};

/// What became of the tags that a pose predicts.
struct GuidedTags {
  std::vector<TagDetection> found;  // sorted by id
  int expected = 0;                 // how many of those looked for were predicted in the image
  bool cut_short = false;           // the time was up before all were looked for
  PosePrediction pose;              // as predicted, and what the tags found say of it
};

struct GuidedOptions {
  /// Of more, so many are looked for, spread over the image: the others tell little that these do
  /// not, and cost as much each.
  size_t most_tags = 26;
  /// Tags that were not found are looked for once more from the pose by those that were, as far off
  /// as lens and map may be.
  bool is_thorough = false;
};

/// Finds tags where a predicted pose says that they are: no search of the image. Each tag is fitted
/// from its predicted corners (CornerRefiner), the ones known best first, and believed only if the
/// fit shows its own pattern there; what it says of the pose then narrows the others' predictions
/// (an extended Kalman filter over the tags of the image). Its state is how each tag looked when it
/// was last seen.
class GuidedDetector {
 public:
  /// Tags nearer than border_px to the image's border are cut and left out.
  GuidedDetector(const Camera& camera, const Pose& cam_from_body, const TagMap& map,
                 double border_px, const GuidedOptions& options = {});

  GuidedTags Find(const cv::Mat& gray, const CornerRefiner& refiner,
                  const PosePrediction& prediction, const TimeUp& time_up = {});

  /// nullopt where the tag is not predicted to lie in the image, whole.
  std::optional<ExpectedTag> Expect(const Tag& tag, const PosePrediction& prediction) const;

  /// How tags looked in this image, found otherwise; replaces what was known.
  void SetLooks(std::unordered_map<int, PatternLook> looks) { looks_ = std::move(looks); }

 private:
  std::vector<ExpectedTag> ExpectAll(const PosePrediction& prediction) const;
  std::optional<RefinedTag> Fit(const cv::Mat& gray, const CornerRefiner& refiner,
                                const ExpectedTag& expected) const;
  std::optional<RefinedTag> FitAgain(const cv::Mat& gray, const CornerRefiner& refiner,
                                     const ExpectedTag& expected, double corner_sigma_px,
                                     bool was_tried) const;

  Camera camera_;
  Pose cam_from_body_;
  TagMap map_;
  double border_px_;
  GuidedOptions options_;
  std::unordered_map<int, PatternLook> looks_;  // by id, of the last image
};

}  // namespace tagtwist::internal
