#include "frontend/tags/tag_sweep.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "frontend/geometry/frame_pose.h"
#include "frontend/geometry/tag_outline.h"
#include "frontend/tags/cut_tags.h"
#include "frontend/tags/filter_tags.h"
#include "frontend/tags/tag_completion.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kLeastTags = 4;  // to guide to all others in the next image
constexpr size_t kLookEvery = 8;
constexpr size_t kMostImages = 48, kLeastImages = 16, kMostBytes = 64 << 20;
constexpr size_t kAllTags = std::numeric_limits<size_t>::max();

size_t BytesOf(const Camera& camera) {
  return static_cast<size_t>(camera.width) * static_cast<size_t>(camera.height);
}

size_t ImagesOf(size_t bytes) {
  return std::clamp(kMostBytes / std::max<size_t>(1, bytes), kLeastImages, kMostImages);
}

Eigen::Vector2d CentrePx(const TagDetection& tag) {
  return 0.25 * (tag.corners[0] + tag.corners[1] + tag.corners[2] + tag.corners[3]);
}

// Of a tag that CompleteTags gave: whether its corners are from its pattern.
bool IsFitted(const TagDetection& tag, const RefinedTags& refined) {
  return refined.IsRefined(tag.id) ||
         std::none_of(refined.tags.begin(), refined.tags.end(), [&](const TagDetection& other) {
           return other.id == tag.id && other.corners == tag.corners;
         });
}

bool Holds(const std::vector<TagDetection>& tags, int id) {
  return std::any_of(tags.begin(), tags.end(), [&](const TagDetection& t) { return t.id == id; });
}

}  // namespace

Result<TagSweep> TagSweep::Create(const SetUp& set_up, const TagDetectorOptions& options,
                                  const CornerRefiner& refiner) {
  TagDetectorOptions halved = options;  // what takes little time, and misses small tags
  halved.upscale = 1;
  halved.decimate = 2;
  auto full = TagDetector::Create(set_up.map.family(), options);
  if (!full) return full.error();
  auto coarse = TagDetector::Create(set_up.map.family(), halved);
  if (!coarse) return coarse.error();
  return TagSweep(set_up, options, refiner, std::move(*full), std::move(*coarse));
}

TagSweep::TagSweep(const SetUp& set_up, const TagDetectorOptions& options,
                   const CornerRefiner& refiner, TagDetector full, TagDetector coarse)
    : map_(set_up.map),
      camera_(set_up.rig.front().camera),
      options_(options),
      refiner_(&refiner),
      full_detector_(std::move(full)),
      coarse_detector_(std::move(coarse)),
      guided_(camera_, Pose(), map_, options.border_px, {kAllTags, /*is_thorough=*/true}) {}

size_t TagSweep::PieceLength(const Camera& camera) { return ImagesOf(BytesOf(camera)); }

size_t TagSweep::PieceLength(const Rig& rig) {
  size_t bytes = 0;
  for (const RigCamera& mounted : rig.cameras) bytes += BytesOf(mounted.camera);
  return ImagesOf(bytes);
}

std::vector<SweptTags> TagSweep::Find(const std::vector<SweepImage>& images) {
  motion_.Clear();
  guided_.SetLooks({});
  is_clean_ = false;
  std::vector<SweptTags> out(images.size());
  size_t unchecked = 0;  // images before it were searched, or looked at
  for (size_t i = 0; i < images.size(); ++i) {
    if (images[i].gray.empty()) continue;
    const bool look = i + 1 == images.size() || i + 1 - unchecked >= kLookEvery;
    GuidedTags guided;
    const Way way = is_clean_ ? FindGuided(images[i], look, &guided) : Way::kTooFew;
    if (way == Way::kFollowed || way == Way::kLooked) {
      motion_.Add(images[i].t_ns, guided.pose);
      seen_.clear();
      for (const TagDetection& tag : guided.found) seen_.push_back(tag.id);
      out[i].tags = std::move(guided.found);
    } else {
      out[i] = SearchAndLearn(images[i]);
    }
    if (way == Way::kMore || (way == Way::kTooFew && !is_clean_)) {  // who knows since when
      for (size_t k = unchecked; k < i; ++k) out[k] = Search(images[k].gray).found;
    }
    if (way != Way::kFollowed) unchecked = i + 1;
  }
  return out;
}

TagSweep::Way TagSweep::FindGuided(const SweepImage& image, bool look, GuidedTags* guided) {
  bool is_found = Guide(image.gray, motion_.At(image.t_ns), guided);
  if (is_found && !look && !MissesSeen(image.gray, *guided)) return Way::kFollowed;
  const std::vector<TagDetection> shown = coarse_detector_.Detect(image.gray);
  if (!is_found) {
    const SweptTags usable{FilterTags(shown, map_, camera_, options_.border_px), {}};
    is_found = Guide(image.gray, Judge(usable, image.t_ns).pose, guided);
  }
  if (!is_found) return Way::kTooFew;
  return ShowsMore(image.gray, shown, guided->found) ? Way::kMore : Way::kLooked;
}

// Whether enough tags are found from there.
bool TagSweep::Guide(const cv::Mat& gray, const std::optional<PosePrediction>& from,
                     GuidedTags* guided) {
  if (!from) return false;
  *guided = guided_.Find(gray, *refiner_, *from);
  return guided->found.size() >= kLeastTags;
}

// A tag whose white margin lies in the image, too: one that is cut may be seen, or not.
bool TagSweep::IsWhole(const cv::Mat& gray, const TagDetection& tag) const {
  const Eigen::AlignedBox2d box = ImageBox(gray);
  const auto outline = GrownOutline(tag, kWhiteMarginOfSide);
  return std::all_of(outline.begin(), outline.end(),
                     [&](const Eigen::Vector2d& corner) { return box.contains(corner); });
}

// Whether a tag of the last image is still in view, and was not found.
bool TagSweep::MissesSeen(const cv::Mat& gray, const GuidedTags& guided) const {
  return std::any_of(seen_.begin(), seen_.end(), [&](int id) {
    if (Holds(guided.found, id)) return false;
    const auto expected = guided_.Expect(*map_.Find(id), guided.pose);
    return expected && IsWhole(gray, expected->tag);
  });
}

// Whether a tag of the map shows where none of its id was found.
bool TagSweep::ShowsMore(const cv::Mat& gray, const std::vector<TagDetection>& shown,
                         const std::vector<TagDetection>& found) const {
  return std::any_of(shown.begin(), shown.end(), [&](const TagDetection& tag) {
    if (map_.Find(tag.id) == nullptr || !IsWhole(gray, tag)) return false;
    const TagDetection* known = TagUnder(CentrePx(tag), found, 0);
    return known == nullptr || known->id != tag.id;
  });
}

TagSweep::Searched TagSweep::Search(const cv::Mat& gray) const {
  Searched out;
  const std::vector<TagDetection> detected = full_detector_.Detect(gray);
  out.found.doubled_ids = DoubledIds(detected, map_);
  out.refined = WithoutCutTags(
      refiner_->RefineAll(gray, FilterTags(detected, map_, camera_, options_.border_px)),
      ImageBox(gray));
  out.found.tags = CompleteTags(gray, *refiner_, map_, camera_, options_.border_px, out.refined);
  return out;
}

// The pose that the tags agree on; of several that they leave open the one that is expected.
TagSweep::Judged TagSweep::Judge(const SweptTags& found, int64_t t_ns) const {
  Judged out;
  const FramePose by_tags = FindFramePose(found.tags, map_, camera_, Pose());
  if (by_tags.status != FramePoseStatus::kOk) return out;
  Pose best = by_tags.world_from_body;
  if (const auto expected = motion_.At(t_ns)) {
    const auto off = [&](const Pose& pose) {
      return AngleBetween(pose, expected->world_from_body);
    };
    for (const Pose& other : by_tags.alternatives) {
      if (off(other) < off(best)) best = other;
    }
  }
  out.pose = PredictionBy(best, by_tags, found.tags, map_, guided_);
  const std::vector<bool>& in_place = by_tags.tag_inlier;
  out.is_clean = out.pose && in_place.size() >= kLeastTags && found.doubled_ids.empty() &&
                 std::all_of(in_place.begin(), in_place.end(), [](bool is) { return is; });
  return out;
}

SweptTags TagSweep::SearchAndLearn(const SweepImage& image) {
  Searched searched = Search(image.gray);
  const Judged judged = Judge(searched.found, image.t_ns);
  const std::vector<TagDetection>& tags = searched.found.tags;
  is_clean_ = judged.is_clean && std::all_of(tags.begin(), tags.end(), [&](const auto& tag) {
                return IsFitted(tag, searched.refined);
              });
  if (judged.pose) motion_.Add(image.t_ns, *judged.pose);
  seen_.clear();
  for (const TagDetection& tag : tags) seen_.push_back(tag.id);
  guided_.SetLooks(std::move(searched.refined.looks));
  return std::move(searched.found);
}

}  // namespace tagtwist::internal
