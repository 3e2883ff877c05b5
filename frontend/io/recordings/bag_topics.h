#pragma once
#include <set>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {

/// The topic to take out of those that would do. Errors (without the bag's name) list them and what
/// a mistyped one may mean.
Result<std::string> ChooseImageTopic(const std::vector<std::string>& topics,
                                     const std::string& wanted);

/// Likewise of those with a camera's calibration, by --camera.
Result<std::string> ChooseCameraTopic(const std::vector<std::string>& topics,
                                      const std::string& wanted);

/// Where a bag's ground truth comes from.
struct TruthTopic {
  std::string name;        // empty: none is taken
  std::string note;        // what a person must know of it; empty: nothing
  std::string child = {};  // of a topic of transforms the frame that is taken; empty: it has poses

  std::string Origin() const;  // in words; empty where none is taken
};
/// The wanted topic, else the only one of `topics`, which have poses. Several and none wanted:
/// none, and a note that lists them. TOPIC:CHILD is wanted of `trees`, the topics of transforms;
/// where they are all there is a note says so.
Result<TruthTopic> ChooseTruth(const std::vector<std::string>& topics,
                               const std::vector<std::string>& trees, const std::string& wanted);

/// One transform of a message: a frame's pose in its parent, whatever that is.
struct FrameTransform {
  std::string child;
  TruthSample sample;
};

/// The transforms of one frame out of messages with many.
class TransformsOfFrame {
 public:
  explicit TransformsOfFrame(TruthTopic topic);
  /// Of the next message. Stamps that do not grow are passed over.
  void Add(const std::vector<FrameTransform>& transforms);
  /// An error where the frame has none: the frames that have.
  Result<std::vector<TruthSample>> Take();

 private:
  TruthTopic topic_;
  std::set<std::string> children_;
  std::vector<TruthSample> taken_;
};

}  // namespace tagtwist::internal
