#pragma once
#include <Eigen/Geometry>
#include <opencv2/core/mat.hpp>

#include "frontend/pattern/corner_refiner.h"

namespace tagtwist::internal {

/// Refined tags, without those whose pattern the refiner did not believe and whose white margin
/// does not lie wholly in what was searched: they are cut at its border, and the quads that a
/// detector makes of such tags are off by some pixels.
RefinedTags WithoutCutTags(RefinedTags refined, const Eigen::AlignedBox2d& searched);
/// Of a whole image, as pixels (from (0, 0) to the centre of the last one).
Eigen::AlignedBox2d ImageBox(const cv::Mat& image);

}  // namespace tagtwist::internal
