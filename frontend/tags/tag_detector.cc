#include "frontend/tags/tag_detector.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>
#include <tuple>
#include <utility>

#include "frontend/base/option_check.h"
#include "frontend/geometry/tag_outline.h"
#include "frontend/types/tag_family.h"
extern "C" {
#include <apriltag/apriltag.h>
}

namespace tagtwist {

using namespace internal;
namespace {

constexpr double kMinSidePx = 16;  // libapriltag reads outside of images with less than one tile

bool IdThenPlace(const TagDetection& a, const TagDetection& b) {
  const auto key = [](const TagDetection& d) {
    return std::make_tuple(d.id, d.corners[0].x(), d.corners[0].y());
  };
  return key(a) < key(b);
}

Eigen::Vector2d Centre(const TagDetection& tag) {
  return 0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
}

}  // namespace

std::optional<std::string> TagDetectorOptions::Problem() const {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  for (auto& problem :
       {CheckRange("upscale", upscale, 1, 4), CheckRange("decimate", decimate, 1, 8),
        CheckRange("quad_sigma", quad_sigma, -10, 10),
        CheckRange("decode_sharpening", decode_sharpening, 0, kInf),
        CheckRange("min_decision_margin", min_decision_margin, 0, kInf),
        CheckRange("max_hamming", max_hamming, 0, 2),
        CheckRange("border_px", border_px, 0, kInf)}) {
    if (problem) return problem;
  }
  // libapriltag takes steps of the integer part, but scales its corners by the whole.
  if (decimate != 1.5 && decimate != std::floor(decimate)) {
    return "decimate: expected 1.5 or an integer, got " + std::to_string(decimate);
  }
  return std::nullopt;
}

struct TagDetector::Impl {
  // The detector is destroyed first: it takes its tables out of the family.
  TagFamilyPointer family;
  std::unique_ptr<apriltag_detector_t, void (*)(apriltag_detector_t*)> detector;
  TagDetectorOptions options;
  bool is_board = false;  // of Kalibr

  std::vector<TagDetection> DetectIn(const cv::Mat& enlarged, double paper_px) const;
  std::vector<TagDetection> DetectOnBoard(const cv::Mat& enlarged) const;
};

TagDetector::TagDetector(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;
TagDetector::~TagDetector() = default;

Result<TagDetector> TagDetector::Create(const std::string& family,
                                        const TagDetectorOptions& options) {
  if (auto problem = options.Problem()) return Error{*problem};
  auto tag_family = CreateTagFamily(family);
  if (!tag_family) return tag_family.error();
  auto impl = std::make_unique<Impl>(Impl{std::move(*tag_family),
                                          {apriltag_detector_create(), apriltag_detector_destroy},
                                          options,
                                          family == kKalibrFamily});
  apriltag_detector_t& detector = *impl->detector;
  apriltag_detector_add_family_bits(&detector, impl->family.get(), options.max_hamming);
  detector.nthreads = 1;
  detector.quad_decimate = static_cast<float>(options.decimate);
  detector.quad_sigma = static_cast<float>(options.quad_sigma);
  detector.refine_edges = options.refine_edges;
  detector.decode_sharpening = options.decode_sharpening;
  return TagDetector(std::move(impl));
}

// `paper_px`: the paper was grown by so much over the ink [px of `gray`]; corners are moved back.
std::vector<TagDetection> TagDetector::Impl::DetectIn(const cv::Mat& enlarged,
                                                      double paper_px) const {
  image_u8_t view{enlarged.cols, enlarged.rows, static_cast<int>(enlarged.step), enlarged.data};
  const std::unique_ptr<zarray_t, void (*)(zarray_t*)> found(
      apriltag_detector_detect(detector.get(), &view), apriltag_detections_destroy);
  std::vector<TagDetection> tags;
  for (int i = 0; i < zarray_size(found.get()); ++i) {
    apriltag_detection_t* detection = nullptr;
    zarray_get(found.get(), i, &detection);
    if (!(detection->decision_margin >= options.min_decision_margin)) continue;
    TagDetection tag;
    tag.id = detection->id;
    for (size_t c = 0; c < 4; ++c) {
      tag.corners[c] = Eigen::Map<const Eigen::Vector2d>(detection->p[c]) / options.upscale;
      tag.corners[c].array() -= 0.5;
    }
    if (paper_px > 0) tag.corners = GrownOutline(tag, paper_px / MeanSidePx(tag));
    tags.push_back(tag);
  }
  return tags;
}

// The squares of a Kalibr board touch its tags' corners, and blurred they are one blot of ink with
// them, which has no outline of four sides: growing the paper parts them.
std::vector<TagDetection> TagDetector::Impl::DetectOnBoard(const cv::Mat& enlarged) const {
  constexpr size_t kEnough = 8;  // for CompleteTags to find the others
  std::vector<TagDetection> tags;
  for (const auto& [shape, side] : {std::pair(cv::MORPH_CROSS, 3),
                                    {cv::MORPH_RECT, 1},
                                    {cv::MORPH_RECT, 3},
                                    {cv::MORPH_CROSS, 5}}) {
    cv::Mat grown;
    cv::dilate(enlarged, grown, cv::getStructuringElement(shape, {side, side}));
    for (const TagDetection& tag : DetectIn(grown, 0.4 * (side - 1) / options.upscale)) {
      if (TagUnder(Centre(tag), tags, 0) == nullptr) tags.push_back(tag);
    }
    if (tags.size() >= kEnough) break;
  }
  return tags;
}

std::vector<TagDetection> TagDetector::Detect(const cv::Mat& gray) const {
  const TagDetectorOptions& options = impl_->options;
  const double min_side_px = kMinSidePx * std::max(options.decimate / options.upscale, 1.0);
  if (gray.type() != CV_8UC1 || std::min(gray.rows, gray.cols) < min_side_px) return {};
  cv::Mat image = gray;
  if (options.upscale > 1) {
    cv::resize(gray, image, {}, options.upscale, options.upscale, cv::INTER_CUBIC);
  }
  std::vector<TagDetection> tags =
      impl_->is_board ? impl_->DetectOnBoard(image) : impl_->DetectIn(image, 0);
  std::sort(tags.begin(), tags.end(), IdThenPlace);
  return tags;
}

}  // namespace tagtwist
