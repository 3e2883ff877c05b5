#include "estimator/jobs/tag_sample.h"

#include <utility>

namespace tagtwist::internal {

void TagSample::Add(const FrameMeasurements& frame) {
  const size_t index = count_++;
  with_two_ += frame.tags.size() >= 2 ? 1 : 0;
  if (index / 3 % stride_ != 0) return;
  SeenTags seen{frame.t_ns, {}};
  seen.tags.reserve(frame.tags.size());
  for (const TagDetection& tag : frame.tags) seen.tags.push_back({tag.id, tag.corners, {}});
  frames_.push_back(std::move(seen));
  indices_.push_back(index);
  if (frames_.size() < kMost) return;
  stride_ *= 2;
  size_t kept = 0;
  for (size_t i = 0; i < frames_.size(); ++i) {
    if (indices_[i] / 3 % stride_ != 0) continue;
    if (kept != i) frames_[kept] = std::move(frames_[i]);
    indices_[kept++] = indices_[i];
  }
  frames_.resize(kept);
  indices_.resize(kept);
}

}  // namespace tagtwist::internal
