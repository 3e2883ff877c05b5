#include "estimator/jobs/find_family.h"

#include <algorithm>
#include <set>
#include <string>
#include <utility>

#include "frontend/base/format_text.h"
#include "frontend/tags/tag_detector.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kImages = 6, kEvery = 8;

std::vector<cv::Mat> SomeImages(DataSource* source) {
  std::vector<cv::Mat> out;
  for (size_t i = 0; out.size() < kImages; ++i) {
    auto frame = source->Next();
    if (!frame || !*frame) break;
    if (i % kEvery == 0 && !(*frame)->image.empty()) out.push_back((*frame)->image.clone());
  }
  return out;
}

struct Seen {
  size_t tags = 0, images = 0;  // images: with a tag
  std::set<int> ids;
};

Seen Look(const std::vector<cv::Mat>& images, const std::string& family) {
  TagDetectorOptions options;
  options.max_hamming = 0;
  options.min_decision_margin = 30;
  Seen out;
  const auto detector = TagDetector::Create(family, options);
  if (!detector) return out;
  for (const cv::Mat& image : images) {
    const std::vector<TagDetection> tags = detector->Detect(image);
    out.tags += tags.size();
    out.images += tags.empty() ? 0 : 1;
    for (const TagDetection& tag : tags) out.ids.insert(tag.id);
  }
  return out;
}

std::string IdsText(const std::set<int>& ids) {
  return Format("%zu ids from %d to %d", ids.size(), *ids.begin(), *ids.rbegin());
}

}  // namespace

std::optional<Fault> FindOtherTags(DataSource* source, const TagMap& map,
                                   const std::vector<std::string>& families) {
  const std::vector<cv::Mat> images = SomeImages(source);
  if (images.empty()) return std::nullopt;
  const Seen own = Look(images, map.family());
  const auto in_map = [&](int id) { return map.Find(id) != nullptr; };
  if (own.ids.size() >= 2 && std::none_of(own.ids.begin(), own.ids.end(), in_map)) {
    return Fault{"The images show tags of " + map.family() + " with " + IdsText(own.ids) +
                     ", none of which the map has.",
                 "It is the map of other tags."};
  }
  Seen best;
  std::string best_name;
  for (const std::string& family : families) {
    if (family == map.family()) continue;
    Seen seen = Look(images, family);
    if (seen.tags <= best.tags) continue;
    best = std::move(seen);
    best_name = family;
  }
  const bool clear = best.tags >= 4 && best.tags >= 5 * own.tags && 2 * best.images > images.size();
  if (!clear) return std::nullopt;
  return Fault{"The images show tags of " + best_name + " (" + IdsText(best.ids) +
                   "), the map has " + map.family() + ".",
               "Name their family in the map, or by --tag_family."};
}

}  // namespace tagtwist::internal
