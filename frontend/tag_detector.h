#pragma once
#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "frontend/types/measurements.h"

namespace cv {
class Mat;
}

namespace tagtwist {

struct TagDetectorOptions {
  int threads = 1;
  double decimate = 1.0;  // image divided by this before the quad search
};

/// libapriltag's detector for one family; corners moved to OpenCV's pixel convention.
class TagDetector {
 public:
  explicit TagDetector(const TagDetectorOptions& options);
  ~TagDetector();
  std::vector<TagDetection> Detect(const cv::Mat& gray) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
}  // namespace tagtwist
