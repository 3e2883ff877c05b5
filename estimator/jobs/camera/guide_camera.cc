#include "estimator/jobs/camera/guide_camera.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>
#include <vector>

#include "estimator/jobs/camera/camera_looks.h"
#include "estimator/jobs/camera/measure_looks.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMostKept = 80;

// What was kept so far; `looks` and `first` frame by frame.
struct Kept {
  Looks looks;
  std::vector<FrameMeasurements> first;
  bool wants_next = false;  // the frame after the last one, which tells how the camera moved
};

// Mean distance of the corners that both see, in image widths; 1 where there are none.
double Apart(const std::vector<TagDetection>& a, const std::vector<TagDetection>& b, int width) {
  double sum = 0;
  int n = 0;
  for (const TagDetection& one : a) {
    const auto other =
        std::find_if(b.begin(), b.end(), [&](const TagDetection& tag) { return tag.id == one.id; });
    if (other == b.end()) continue;
    for (size_t c = 0; c < 4; ++c) sum += (one.corners[c] - other->corners[c]).norm();
    n += 4;
  }
  return n == 0 ? 1 : sum / n / width;
}

bool IsNew(const std::vector<TagDetection>& tags, const Kept& kept) {
  constexpr double kApart = 0.06;  // image widths
  return std::all_of(kept.first.begin(), kept.first.end(), [&](const FrameMeasurements& frame) {
    return Apart(tags, frame.tags, kept.looks.width) > kApart;
  });
}

// Whether the frame was kept as one that differs from all before.
bool Take(const Frame& frame, std::vector<TagDetection> tags, Kept* kept) {
  constexpr double kNearS = 0.1;
  if (tags.size() < 2 || kept->first.size() >= kMostKept) return false;
  const bool is_next = std::exchange(kept->wants_next, false) &&
                       ToSeconds(frame.t_ns - kept->first.back().t_ns) <= kNearS;
  const bool is_new = !is_next && IsNew(tags, *kept);
  if (!is_next && !is_new) return false;
  kept->looks.looks.push_back({frame.t_ns, frame.image.clone(), {}});
  kept->first.emplace_back();
  kept->first.back().t_ns = frame.t_ns;
  kept->first.back().tags = std::move(tags);
  kept->wants_next = is_new;
  return is_new;
}

// The lens, where what is kept makes it good; tells what is missing where it does not.
std::optional<LensFound> TryLens(const CameraJob& job, const TagMap& map, const Kept& kept,
                                 const CameraGuide& guide) {
  const std::string head = std::to_string(kept.first.size()) + " frames kept; ";
  const auto started = StartLooks(map, kept.looks, kept.first);
  if (!started || !started->starts.missing.empty()) {
    guide.tell(head + (started ? AsSentence(started->starts.missing) : started.error().message));
    return std::nullopt;
  }
  guide.tell(head + "calibrating");
  auto found = FindLensOfLooks(job, map, kept.looks, kept.first);
  if (found && found->missing.empty()) return std::move(*found);
  guide.tell(head + (found ? AsSentence(found->missing) : found.error().message));
  return std::nullopt;
}

}  // namespace

Result<LensFound> GuideCamera(const CameraJob& job, const TagMap& map, DataSource* camera,
                              const CameraGuide& guide) {
  constexpr int kEvery = 4;  // frames that are new
  const TagDetectorOptions options;
  const auto detector = TagDetector::Create(map.family(), options);
  if (!detector) return detector.error();
  guide.tell("show the tags: near and far, in all parts of the image, tilted; Ctrl-C ends it");
  Kept kept;
  int n_new = 0;
  while (!guide.stop() && kept.first.size() < kMostKept) {
    const auto frame = camera->Next();
    if (!frame) return frame.error();
    if (!*frame) break;
    if ((*frame)->image.empty()) continue;
    if (const Status sized = TakeSize(**frame, &kept.looks); !sized) return sized.error();
    auto tags = TagsOfMap(detector->Detect((*frame)->image), map, kept.looks, options.border_px);
    if (!Take(**frame, std::move(tags), &kept) || ++n_new % kEvery != 0) continue;
    if (auto found = TryLens(job, map, kept, guide)) return std::move(*found);
  }
  if (kept.first.empty()) return Error{job.recording + ": no frame showed two tags"};
  return FindLensOfLooks(job, map, kept.looks, kept.first);
}

}  // namespace tagtwist::internal
