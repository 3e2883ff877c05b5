#include "estimator/jobs/camera/guide_camera.h"

#include <algorithm>
#include <chrono>
#include <future>
#include <string>
#include <utility>
#include <vector>

#include "estimator/jobs/camera/camera_looks.h"
#include "estimator/jobs/camera/measure_looks.h"
#include "frontend/tags/tag_detector.h"
#include "frontend/types/body_state.h"

namespace tagtwist::internal {
namespace {

constexpr size_t kMostKept = 80;

// What was kept so far; `looks`, `first` and `is_new` frame by frame.
struct Kept {
  Looks looks;
  std::vector<FrameMeasurements> first;
  std::vector<bool> is_new;  // false: the frame after one that is, which tells how the camera moved
  bool wants_next = false;   // the frame after the last one
};

// Makes room: of the frames that are new every second one goes, with its next.
void Thin(Kept* kept) {
  Kept out;
  out.looks.width = kept->looks.width, out.looks.height = kept->looks.height;
  bool stays = false;
  for (size_t i = 0; i < kept->first.size(); ++i) {
    if (kept->is_new[i]) stays = !stays;
    if (!stays) continue;
    out.looks.looks.push_back(std::move(kept->looks.looks[i]));
    out.first.push_back(std::move(kept->first[i]));
    out.is_new.push_back(kept->is_new[i]);
  }
  *kept = std::move(out);
}

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
  if (tags.size() < 2) return false;
  const bool is_next = std::exchange(kept->wants_next, false) &&
                       ToSeconds(frame.t_ns - kept->first.back().t_ns) <= kNearS;
  const bool is_new = !is_next && IsNew(tags, *kept);
  if (!is_next && !is_new) return false;
  if (is_new && kept->first.size() + 2 > kMostKept) Thin(kept);
  kept->is_new.push_back(is_new);
  kept->looks.looks.push_back({frame.t_ns, frame.image.clone(), {}});
  kept->first.emplace_back();
  kept->first.back().t_ns = frame.t_ns;
  kept->first.back().tags = std::move(tags);
  kept->wants_next = is_new;
  return is_new;
}

// What came of what is kept.
struct Tried {
  std::string words;
  std::shared_ptr<const LensFound> lens = {};
  bool is_good() const { return lens != nullptr && lens->missing.empty(); }
};

// job.accepts_poor: a lens of views that are not good, too. `tell`: that it calibrates.
Tried TryLens(const CameraJob& job, const TagMap& map, const Kept& kept,
              const std::function<void(const std::string& line)>& tell) {
  const std::string head = std::to_string(kept.first.size()) + " frames kept; ";
  const auto started = StartLooks(map, kept.looks, kept.first);
  if (!started) return {head + started.error().message};
  const std::string missing = AsSentence(started->starts.missing);
  if (!missing.empty() && !job.accepts_poor) return {head + missing};
  tell(head + "calibrating");
  auto found = FindLensOfLooks(job, map, kept.looks, kept.first);
  if (!found) return {head + (missing.empty() ? found.error().message : missing)};
  const auto lens = std::make_shared<const LensFound>(std::move(*found));
  return {lens->missing.empty() ? "" : head + AsSentence(lens->missing), lens};
}

// Tries a lens now and then: where it is watched beside the frames, else between them.
class Trials {
 public:
  Trials(const CameraJob& job, const TagMap& map, const CameraGuide& guide)
      : job_(job), map_(map), guide_(guide) {
    job_.accepts_poor = guide_.show != nullptr;
  }

  // Whether a lens is good: by what is kept, where it is time, or was tried before.
  bool Try(const Kept& kept, bool is_new) {
    const int every = guide_.show ? 2 : 4;  // frames that are new
    if (is_new) ++n_new_;
    if (IsDone()) Take(under_way_.get());
    if (last_.is_good()) return true;
    if (under_way_.valid() || n_new_ < every) return false;
    n_new_ = 0;
    if (!guide_.show) {
      Take(TryLens(job_, map_, kept, guide_.tell));
      return last_.is_good();
    }
    under_way_ = std::async(std::launch::async, [this, kept] {
      return TryLens(job_, map_, kept, [](const std::string&) {});
    });
    return false;
  }
  // Of what is under way, too.
  bool EndsGood() {
    if (under_way_.valid()) Take(under_way_.get());
    return last_.is_good();
  }
  bool is_under_way() const { return under_way_.valid(); }
  const Tried& last() const { return last_; }

 private:
  bool IsDone() const {
    return under_way_.valid() &&
           under_way_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
  }
  void Take(Tried tried) {
    if (!tried.words.empty()) guide_.tell(tried.words);
    if (tried.lens == nullptr) tried.lens = last_.lens;  // a poor one is better than none
    last_ = std::move(tried);
  }

  CameraJob job_;
  const TagMap& map_;
  const CameraGuide& guide_;
  Tried last_;
  int n_new_ = 0;
  std::future<Tried> under_way_;  // last member: it uses the others
};

ViewsJudged CornersOf(const Kept& kept) {
  ViewsJudged out;
  for (const FrameMeasurements& frame : kept.first) {
    for (const TagDetection& tag : frame.tags) {
      CountCorners(tag, kept.looks.width, kept.looks.height, &out);
    }
  }
  out.pixels.clear();
  return out;
}

void Show(const Trials& trials, const Kept& kept, const CameraGuide& guide, GuideView* view) {
  if (view->kept != kept.first.size()) view->seen = CornersOf(kept);
  view->kept = kept.first.size();
  if (!trials.last().words.empty()) view->words = trials.last().words;
  view->is_calibrating = trials.is_under_way();
  view->lens = trials.last().lens;
  guide.show(*view);
}

}  // namespace

Result<LensFound> GuideCamera(const CameraJob& job, const TagMap& map, DataSource* camera,
                              const CameraGuide& guide) {
  const TagDetectorOptions options;
  const auto detector = TagDetector::Create(map.family(), options);
  if (!detector) return detector.error();
  GuideView view;
  view.words = "show the tags: near and far, in all parts of the image, tilted; Ctrl-C ends it";
  guide.tell(view.words);
  Kept kept;
  Trials trials(job, map, guide);
  while (!guide.stop()) {
    auto frame = camera->Next();
    if (!frame) return frame.error();
    if (!*frame) break;
    if ((*frame)->image.empty()) continue;
    if (const Status sized = TakeSize(**frame, &kept.looks); !sized) return sized.error();
    view.t_ns = (*frame)->t_ns;
    view.image = (*frame)->image;
    view.tags = TagsOfMap(detector->Detect(view.image), map, kept.looks, options.border_px);
    const bool is_new = Take(**frame, view.tags, &kept);
    const bool is_good = trials.Try(kept, is_new);
    if (guide.show) Show(trials, kept, guide, &view);
    if (is_good) return *trials.last().lens;
  }
  if (kept.first.empty()) return Error{job.recording + ": no frame showed two tags"};
  if (trials.EndsGood()) return *trials.last().lens;
  return FindLensOfLooks(job, map, kept.looks, kept.first);
}

}  // namespace tagtwist::internal
