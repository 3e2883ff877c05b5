#include "frontend/tags/cut_tags.h"

#include <algorithm>

#include "frontend/geometry/tag_outline.h"

namespace tagtwist::internal {

RefinedTags WithoutCutTags(RefinedTags refined, const Eigen::AlignedBox2d& searched) {
  const auto is_cut = [&](const TagDetection& tag) {
    if (refined.IsRefined(tag.id)) return false;
    const auto outline = GrownOutline(tag, kWhiteMarginOfSide);
    return !std::all_of(outline.begin(), outline.end(),
                        [&](const Eigen::Vector2d& corner) { return searched.contains(corner); });
  };
  auto& tags = refined.tags;
  tags.erase(std::remove_if(tags.begin(), tags.end(), is_cut), tags.end());
  return refined;
}

Eigen::AlignedBox2d ImageBox(const cv::Mat& image) {
  return {Eigen::Vector2d::Zero(), Eigen::Vector2d(image.cols - 1, image.rows - 1)};
}

}  // namespace tagtwist::internal
