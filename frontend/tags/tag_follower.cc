#include "frontend/tags/tag_follower.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "frontend/geometry/tag_outline.h"
#include "frontend/tags/cut_tags.h"
#include "frontend/tags/find_tags.h"
#include "frontend/tags/tag_completion.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kEnoughTags = 4;  // to guide to all others in the next image

}  // namespace

Result<TagFollower> TagFollower::Create(const SetUp& set_up, const TagDetectorOptions& options) {
  auto full = TagDetector::Create(set_up.map.family(), options);
  if (!full) return full.error();
  TagDetectorOptions plain_options = options;  // what takes less time, and misses small tags
  plain_options.upscale = 1;
  plain_options.decimate = 1;
  auto plain = TagDetector::Create(set_up.map.family(), plain_options);
  if (!plain) return plain.error();
  auto refiner = CornerRefiner::Create(set_up.map, set_up.rig.front().camera);
  if (!refiner) return refiner.error();
  return TagFollower(set_up, options, std::move(*full), std::move(*plain), std::move(*refiner));
}

TagFollower::TagFollower(const SetUp& set_up, const TagDetectorOptions& options, TagDetector full,
                         TagDetector plain, CornerRefiner refiner)
    : map_(set_up.map),
      camera_(set_up.rig.front().camera),
      border_px_(options.border_px),
      full_detector_(std::move(full)),
      plain_detector_(std::move(plain)),
      refiner_(std::move(refiner)),
      guided_(camera_, set_up.rig.front().cam_from_body, map_, options.border_px) {}

std::vector<TagDetection> TagFollower::Find(const cv::Mat& gray,
                                            const std::optional<PosePrediction>& prediction,
                                            const TimeUp& time_up) {
  was_cut_short_ = false;
  doubled_ids_.clear();
  if (gray.empty()) return {};
  if (!prediction) return SearchAll(gray, time_up);
  GuidedTags guided = guided_.Find(gray, refiner_, *prediction, time_up);
  if (policy_.AfterGuided(guided.expected, static_cast<int>(guided.found.size()))) {
    return SearchAll(gray, time_up);
  }
  was_cut_short_ = guided.cut_short;
  if (IsUp(time_up)) return std::move(guided.found);
  const auto part = policy_.NextPart();
  return part ? SearchPart(gray, *part, guided.found) : std::move(guided.found);
}

std::vector<TagDetection> TagFollower::Filtered(const std::vector<TagDetection>& tags) {
  for (const int id : DoubledIds(tags, map_)) {
    const auto place = std::lower_bound(doubled_ids_.begin(), doubled_ids_.end(), id);
    if (place == doubled_ids_.end() || *place != id) doubled_ids_.insert(place, id);
  }
  return FilterTags(tags, map_, camera_, border_px_);
}

std::vector<TagDetection> TagFollower::SearchAll(const cv::Mat& gray, const TimeUp& time_up) {
  if (time_up) return SearchParts(gray, time_up);
  auto found = Filtered(plain_detector_.Detect(gray));
  if (found.size() < kEnoughTags) {  // small ones, or blurred
    found = Filtered(full_detector_.Detect(gray));
  }
  RefinedTags refined = WithoutCutTags(refiner_.RefineAll(gray, found), ImageBox(gray));
  auto tags = CompleteTags(gray, refiner_, map_, camera_, border_px_, refined);
  guided_.SetLooks(std::move(refined.looks));
  policy_.AfterFull(static_cast<int>(tags.size()));
  return tags;
}

std::vector<TagDetection> TagFollower::SearchParts(const cv::Mat& gray, const TimeUp& time_up) {
  std::vector<TagDetection> tags;
  for (int i = 0; i < DetectionPolicy::kParts && !was_cut_short_; ++i) {
    tags = SearchPart(gray, policy_.TakePart(), tags);
    was_cut_short_ = i + 1 < DetectionPolicy::kParts && IsUp(time_up);
  }
  policy_.AfterFull(static_cast<int>(tags.size()));
  return tags;
}

// What is known, and what else lies in the part. An id that is seen at two places is dropped.
std::vector<TagDetection> TagFollower::SearchPart(const cv::Mat& gray,
                                                  const Eigen::AlignedBox2d& part,
                                                  const std::vector<TagDetection>& known) {
  const Eigen::Vector2d size(gray.cols, gray.rows);
  const Eigen::Vector2i low = part.min().cwiseProduct(size).cast<int>();
  const Eigen::Vector2i high =
      part.max().cwiseProduct(size).cast<int>().cwiseMin(Eigen::Vector2i(gray.cols, gray.rows));
  const cv::Mat cut = gray(cv::Range(low.y(), high.y()), cv::Range(low.x(), high.x()));
  std::vector<TagDetection> fresh;
  for (TagDetection tag : plain_detector_.Detect(cut)) {
    for (auto& corner : tag.corners) corner += low.cast<double>();
    const Eigen::Vector2d centre =
        0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
    const TagDetection* same = TagUnder(centre, known, 0);
    if (same == nullptr || same->id != tag.id) fresh.push_back(tag);
  }
  if (fresh.empty()) return known;
  const Eigen::AlignedBox2d searched(low.cast<double>(),
                                     (high.array() - 1).matrix().cast<double>());
  fresh = WithoutCutTags(refiner_.RefineAll(gray, Filtered(fresh)), searched).tags;
  fresh.insert(fresh.end(), known.begin(), known.end());
  return Filtered(fresh);
}

}  // namespace tagtwist::internal
