#pragma once
#include <Eigen/Core>
#include <array>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/pattern/pattern_state.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace cv {
class Mat;
}

namespace tagtwist::internal {

/// Corners from the whole pattern of a tag.
struct RefinedTag {
  std::array<Eigen::Vector2d, 4> corners;  // p1..p4 [px], in the image, distorted as the lens does
  Eigen::Matrix<double, 8, 8> covariance;  // u1 v1 .. u4 v4 [px^2]
  Eigen::Matrix2d blur_px2;                // covariance of the blur, the pixel's square included
  double contrast_grey = 0;                // white less black
  double noise_grey = 0;                   // standard deviation of the residuals
  double inlier_share = 0;                 // pixels that fit, 0 to 1
  double contradicted_share = 0;           // pixels that show the opposite colour, 0 to 1
  PatternLook look;
};

/// All tags of an image, in the order given, and the looks of those whose fit was believed, by id.
struct RefinedTags {
  std::vector<TagDetection> tags;
  std::unordered_map<int, PatternLook> looks;

  bool IsRefined(int id) const { return looks.count(id) > 0; }
};

/// Refines the corners of detected (or predicted) tags: the whole known pattern, blurred and lit as
/// the image demands, is aligned to the intensities (PatternFit). Immutable; one may serve several
/// threads.
class CornerRefiner {
 public:
  /// For the tags of a map; an id that the family lacks is an error.
  static Result<CornerRefiner> Create(const TagMap& map, const Camera& camera);
  CornerRefiner(CornerRefiner&&) noexcept;
  CornerRefiner& operator=(CornerRefiner&&) noexcept;
  ~CornerRefiner();

  /// nullopt when the fit is not believable: no contrast, too few pixels, another pattern, a large
  /// part hidden, corners further than search_px + 1 from the start. The start may be off by half a
  /// cell, and with search_px [px] by that much more as a shift.
  std::optional<RefinedTag> Refine(const cv::Mat& gray, const TagDetection& tag,
                                   double search_px = 0) const;
  /// Refine for a tag that was refined in an image shortly before, from a start that is off by
  /// off_px, and by more than 0.5 px as a shift only: faster.
  std::optional<RefinedTag> Follow(const cv::Mat& gray, const TagDetection& tag,
                                   const PatternLook& look, double off_px) const;

  /// Corners and covariances of all tags of an image (8-bit gray). A tag whose fit Refine does not
  /// believe keeps its corners, with 1 px as their standard deviation.
  RefinedTags RefineAll(const cv::Mat& gray, const std::vector<TagDetection>& tags) const;

  /// How well the image correlates with the tag's pattern there, -1 to 1, from some of the pixels.
  double Correlation(const cv::Mat& gray, const TagDetection& tag) const;

 private:
  struct Impl;
  explicit CornerRefiner(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist::internal
