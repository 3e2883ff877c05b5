#include "frontend/tags/tag_finder.h"

#include <opencv2/core/mat.hpp>
#include <utility>

#include "frontend/pattern/corner_refiner.h"
#include "frontend/tags/find_tags.h"

namespace tagtwist {

using namespace internal;

struct TagFinder::Impl {
  SetUp set_up;
  TagDetectorOptions options;
  TagDetector detector;
  CornerRefiner refiner;
};

Result<TagFinder> TagFinder::Create(const SetUp& set_up, const TagDetectorOptions& options) {
  auto detector = TagDetector::Create(set_up.map.family(), options);
  if (!detector) return detector.error();
  auto refiner = CornerRefiner::Create(set_up.map, set_up.rig.front().camera);
  if (!refiner) return refiner.error();
  return TagFinder(
      std::make_unique<Impl>(Impl{set_up, options, std::move(*detector), std::move(*refiner)}));
}

TagFinder::TagFinder(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TagFinder::TagFinder(TagFinder&&) noexcept = default;
TagFinder& TagFinder::operator=(TagFinder&&) noexcept = default;
TagFinder::~TagFinder() = default;

std::vector<TagDetection> TagFinder::Find(const cv::Mat& gray,
                                          std::vector<int>* doubled_ids) const {
  return FindTags(gray, impl_->detector, impl_->refiner, impl_->set_up.map,
                  impl_->set_up.rig.front().camera, impl_->options, doubled_ids);
}

}  // namespace tagtwist
