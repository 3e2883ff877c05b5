#pragma once
#include <string>

#include "estimator/graph/graph_builder.h"
#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// What is drawn over a frame's image, in pixels whose centres are integers: each tag as it was
/// seen, whether the state was made with it, and if not, why; the map's tags and their axes where
/// the state puts them; the map's own axes.
class PictureNumbers {
 public:
  explicit PictureNumbers(const PublishedRun& run);
  /// One JSON object: docs/live.md has its keys.
  std::string Json(const PublishedFrame& frame) const;
  /// Why the state was made without a tag that was seen, in a few words: "lies 41 mm from where the
  /// map has it".
  std::string WhySetAside(const PublishedFrame& frame, const TagDetection& tag) const;

 private:
  EstimatorSetup setup_;
};

/// Whether the state of a frame was made with the tag.
bool IsUsed(const PublishedFrame& frame, int id);

}  // namespace tagtwist::internal
