#pragma once
#include <Eigen/Geometry>
#include <optional>

namespace tagtwist::internal {

/// When guided detection is not enough. Frame after frame: where the guided detector was asked,
/// AfterGuided says whether its tags will do; where it was not, or they will not, the whole image
/// is searched, and AfterFull told. What nothing predicts (a tag that is not where the map says) is
/// caught by searching one part of the image after another, a few frames apart, so that no frame
/// takes long.
class DetectionPolicy {
 public:
  /// True when the camera is lost: none of the expected tags was found, or fewer than half of as
  /// many as a moment ago.
  bool AfterGuided(int expected, int found);
  void AfterFull(int found);

  /// The part of the image that is to be searched besides in a guided frame, as fractions of its
  /// width and height; call once a guided frame.
  std::optional<Eigen::AlignedBox2d> NextPart();
  /// The next part whatever the frame: kParts of them are the whole image.
  Eigen::AlignedBox2d TakePart();
  static constexpr int kParts = 20;

 private:
  int last_found_ = 0;
  int frames_since_part_ = 0;
  int part_ = 0;
};

}  // namespace tagtwist::internal
