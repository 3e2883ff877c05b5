#pragma once
#include <cstddef>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/publish/json_text.h"
#include "estimator/publish/published_frame.h"

namespace tagtwist::internal {

/// What is drawn over a camera's image, in pixels whose centres are integers: each tag as it was
/// seen, whether its body's state was made with it, and if not, why; the tags of the map and of all
/// bodies and their axes where the states put them; the axes of the map and of each body.
class PictureNumbers {
 public:
  explicit PictureNumbers(const PublishedRun& run);
  /// One JSON object: docs/live.md has its keys.
  std::string Json(const PublishedFrame& frame, size_t camera) const;
  /// Why the state was made without a tag that was seen, in a few words: "lies 41 mm from where the
  /// map has it".
  std::string WhySetAside(const PublishedFrame& frame, size_t body, const TagDetection& tag) const;

 private:
  // The pose of what carries the cameras over the body's tags; where they stand, the body's.
  Pose PoseOver(const PublishedFrame& frame, size_t body) const;
  void AppendSeen(const PublishedFrame& frame, size_t camera, JsonText* json) const;
  void AppendTags(const PublishedFrame& frame, size_t camera, size_t body, JsonText* json) const;

  std::vector<std::string> camera_names_;
  std::vector<EstimatorSetup> setups_;  // of each body
  std::vector<bool> tags_move_;
};

/// Whether the state of a body was made with the tag.
bool IsUsed(const SeenBody& body, int id);

}  // namespace tagtwist::internal
