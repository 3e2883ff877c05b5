#pragma once
#include <optional>
#include <string>
#include <vector>

#include "estimator/graph/graph_builder.h"
#include "estimator/start/size_factor.h"
#include "frontend/base/result.h"
#include "frontend/types/camera.h"
#include "frontend/types/measurements.h"
#include "frontend/types/tag_map.h"

namespace tagtwist::internal {

/// Whether what is seen can be told apart from what the set-up says: that tags are seen from their
/// front, with their corners in order, in a picture that is not mirrored, and that their sizes fit
/// their places. Evidence is gathered frame by frame and is enough after a bounded number of them:
/// 5 tags that run clockwise, or ten frames with two tags and more; then it costs nothing more
/// but the look at each tag's turn.
class SetUpCheck {
 public:
  SetUpCheck(TagMap map, Camera camera);

  /// The tags of a frame, all of the map. An error, in one line, once it is clear that no estimate
  /// can be right.
  Status Add(const std::vector<TagDetection>& tags);
  /// The same at the end of a recording: with whatever evidence there is.
  Status Finish() const;

 private:
  Status JudgeTurns(int least) const;
  Status JudgeFrames(int least_tags) const;
  void ForgetFrames();

  TagMap map_;
  Camera camera_;
  int clockwise_ = 0, anticlockwise_ = 0;                    // tags
  std::vector<std::vector<TagDetection>> clockwise_frames_;  // the first ones with two tags
  std::vector<std::vector<TagDetection>> frames_;            // likewise, of the others,
  std::vector<std::optional<SizeFactor>> size_factors_;      // of these,
  int agreeing_tags_ = 0;                                    // and the tags that agree as told
  int rounds_ = 0;  // of frames that were judged without an answer
  bool frames_are_judged_ = false;
};

/// SetUpCheck of each camera of a rig; errors name the camera where there are several.
class RigCheck {
 public:
  explicit RigCheck(const EstimatorSetup& setup);
  Status Add(const std::vector<TagDetection>& tags);
  Status Finish() const;

 private:
  Status OfCamera(size_t camera, Status status) const;

  std::vector<SetUpCheck> checks_;
  std::vector<std::string> names_;
};

}  // namespace tagtwist::internal
