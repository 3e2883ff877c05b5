#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/types/measurements.h"

namespace cv {
class Mat;
}

namespace tagtwist {

/// Field names are the YAML keys of the section `detector`. The defaults suit small images (376 x
/// 240): on the enlarged image libapriltag's corners, which it finds by sampling whole pixels, are
/// about half as noisy, and quads of few pixels are found (87 to 93 % on real frames). With
/// decimate 2 that costs no more than the image as it is, with fewer small tags.
struct TagDetectorOptions {
  int upscale = 2;                   // the image enlarged by this (bicubic), in [1, 4]
  double decimate = 1.5;             // and divided by this for the quad search: 1, 1.5, 2, 3 .. 8
  double quad_sigma = 0.0;           // blur (> 0) or sharpening (< 0) before the quad search [px]
  bool refine_edges = true;          // quads snapped to the strongest gradients
  double decode_sharpening = 0.25;   // of the sampled bits, >= 0
  double min_decision_margin = 5.0;  // mean contrast of bits against the threshold [gray], >= 0
  int max_hamming = 1;               // bits corrected, in [0, 2]; 2 lets wrong tags in
  double border_px = 1.5;            // tags nearer to the image's border are cut: left out, >= 0
  bool refine_pattern = true;        // corners from the whole pattern (CornerRefiner)

  std::optional<std::string> Problem() const;

  template <typename Self, typename Visitor>
  static void VisitFields(Self& self, Visitor&& visit) {
    visit("upscale", self.upscale);
    visit("decimate", self.decimate);
    visit("quad_sigma", self.quad_sigma);
    visit("refine_edges", self.refine_edges);
    visit("decode_sharpening", self.decode_sharpening);
    visit("min_decision_margin", self.min_decision_margin);
    visit("max_hamming", self.max_hamming);
    visit("border_px", self.border_px);
    visit("refine_pattern", self.refine_pattern);
  }
};

/// libapriltag's detector for one family; corners moved to OpenCV's pixel convention (libapriltag
/// puts the centre of the top-left pixel at (0.5, 0.5)). One thread at a time per detector; a
/// caller with several threads makes several detectors.
class TagDetector {
 public:
  /// The family by libapriltag's name ("tag36h11"); an unknown one is an error.
  static Result<TagDetector> Create(const std::string& family, const TagDetectorOptions& options);
  TagDetector(TagDetector&&) noexcept;
  TagDetector& operator=(TagDetector&&) noexcept;
  ~TagDetector();

  /// All tags found in an 8-bit gray image, ids repeated and unknown ones included, sorted by id,
  /// then by place. An image that is empty, tiny or of another type has none.
  std::vector<TagDetection> Detect(const cv::Mat& gray) const;

 private:
  struct Impl;
  explicit TagDetector(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace tagtwist
