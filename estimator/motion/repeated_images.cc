#include "estimator/motion/repeated_images.h"

#include <algorithm>
#include <cmath>

#include "frontend/base/format_text.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {
namespace {

using TagsById = std::vector<std::pair<int, std::array<Eigen::Vector2d, 4>>>;

constexpr double kLeastMotionPx = 0.05;  // of corners, RMS, between two images

// The step of the values' grid [px]: of a detector, or a file, that rounds to full pixels or so,
// slow corners stay where they were. 0: none.
double GridOf(const TagsById& tags) {
  for (const double step_px : {1.0, 0.5, 0.25, 0.1, 0.05, 0.01}) {
    const auto is_on_grid = [&](double value) {
      return std::abs(std::remainder(value, step_px)) < 1e-6 * step_px;
    };
    const bool all = std::all_of(tags.begin(), tags.end(), [&](const auto& tag) {
      return std::all_of(tag.second.begin(), tag.second.end(), [&](const Eigen::Vector2d& corner) {
        return is_on_grid(corner.x()) && is_on_grid(corner.y());
      });
    });
    if (all) return step_px;
  }
  return 0;
}

// Without a tag in common nothing is known to stand.
bool Moves(const TagsById& before, const TagsById& now) {
  double sum = 0;
  size_t n = 0;
  for (const auto& [id, corners] : now) {
    const auto other =
        std::lower_bound(before.begin(), before.end(), id,
                         [](const auto& tag, int sought) { return tag.first < sought; });
    if (other == before.end() || other->first != id) continue;
    for (size_t i = 0; i < corners.size(); ++i, ++n) {
      sum += (corners[i] - other->second[i]).squaredNorm();
    }
  }
  return n == 0 || std::sqrt(sum / static_cast<double>(n)) > kLeastMotionPx + GridOf(now);
}

}  // namespace

bool RepeatedImages::IsRepeated(const FrameMeasurements& frame, int camera) {
  Tags& tags = now_;
  tags.clear();
  for (const TagDetection& tag : frame.tags) {
    if (tag.camera == camera) tags.emplace_back(tag.id, tag.corners);
  }
  std::sort(tags.begin(), tags.end(),
            [](const auto& a, const auto& b) { return a.first < b.first; });
  const auto& same = frame.same_image;
  const bool is_same_image = std::find(same.begin(), same.end(), camera) != same.end();
  Seen& seen = seen_[camera];
  if (is_same_image || (!tags.empty() && tags == seen.tags)) return seen.moves;
  if (!tags.empty() && !seen.tags.empty()) seen.moves = Moves(seen.tags, tags);
  std::swap(seen.tags, tags);
  return false;
}

void RepeatedImages::TakeOut(FrameMeasurements* frame) {
  cameras_.clear();
  const auto add = [&](int camera) {
    if (std::find(cameras_.begin(), cameras_.end(), camera) == cameras_.end()) {
      cameras_.push_back(camera);
    }
  };
  for (const int camera : frame->cameras) add(camera);
  for (const TagDetection& tag : frame->tags) add(tag.camera);
  for (const int camera : frame->same_image) add(camera);
  if (cameras_.empty()) add(0);  // it saw nothing
  bool any = false;
  for (const int camera : cameras_) {
    if (!IsRepeated(*frame, camera)) continue;
    any = true;
    const auto of_it = [camera](const auto& seen) { return seen.camera == camera; };
    auto& tags = frame->tags;
    tags.erase(std::remove_if(tags.begin(), tags.end(), of_it), tags.end());
    auto& tracks = frame->tracks;
    tracks.erase(std::remove_if(tracks.begin(), tracks.end(), of_it), tracks.end());
    frame->closed_form = {};
  }
  if (!any) return;
  if (count_++ == 0) first_ns_ = frame->t_ns;
}

std::optional<std::string> RepeatedImages::Warning() const {
  if (count_ == 0) return std::nullopt;
  return Format(
      "%zu frame%s, first at %.3f s, repeat%s the image before to the last bit while the tags "
      "move: the camera or the recorder gave an image twice; they are predicted, not measured",
      count_, count_ == 1 ? "" : "s", ToSeconds(first_ns_), count_ == 1 ? "s" : "");
}

}  // namespace tagtwist::internal
