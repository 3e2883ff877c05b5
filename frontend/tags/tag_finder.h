#pragma once
#include <memory>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/measurements.h"
#include "frontend/types/rig.h"

namespace cv {
class Mat;
}

namespace tagtwist {

/// Finds the usable tags of images: detected, filtered, and unless the options say not their
/// corners refined on the whole pattern, with covariances, then those found that the detector
/// missed. One thread at a time.
class TagFinder {
 public:
  /// An error: the map's family or ids are unknown.
  static Result<TagFinder> Create(const SetUp& set_up, const TagDetectorOptions& options);
  TagFinder(TagFinder&&) noexcept;
  TagFinder& operator=(TagFinder&&) noexcept;
  ~TagFinder();

  /// Of an 8-bit gray image; one that is empty or of another type has none. Sorted by id.
  /// `doubled_ids` gets the DoubledIds.
  std::vector<TagDetection> Find(const cv::Mat& gray,
                                 std::vector<int>* doubled_ids = nullptr) const;

 private:
  struct Impl;
  explicit TagFinder(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist
