#include "estimator/jobs/measurement_stream.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "estimator/live/stopwatch.h"
#include "estimator/online/image_size.h"
#include "estimator/online/measure_frame.h"
#include "frontend/tags/find_tags.h"

namespace tagtwist::internal {
namespace {

Status CheckImageSize(const Frame& frame, const Rig& rig) {
  const auto camera = static_cast<size_t>(frame.camera);
  const auto problem = ImageSizeProblem(frame.image, rig.cameras.at(camera).camera);
  return problem ? Status(Error{frame.name + ": " + *problem}) : Ok();
}

void Merge(const MeasuredFrame& other, MeasuredFrame* frame) {
  AddCamera(other.measurements, &frame->measurements);
  for (size_t i = 0; i < other.of_others.size(); ++i) {
    AddCamera(other.of_others[i], &frame->of_others[i]);
  }
  if (frame->image_problem.empty()) frame->image_problem = other.image_problem;
  frame->images.insert(frame->images.end(), other.images.begin(), other.images.end());
  frame->detect_ms += other.detect_ms;
  frame->track_ms += other.track_ms;
  frame->seed_ms += other.seed_ms;
}

// Ids that a frame's own detections double, and those that it tells of besides.
std::vector<int> DoubledIdsOf(const Frame& frame, const TagMap& map) {
  std::vector<int> out = DoubledIds(frame.detections, map);
  for (const int id : frame.doubled_ids) {
    if (map.Find(id) != nullptr) out.push_back(id);
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

bool IsSwept(const Config& config, DetectionMode detection) {
  return detection != DetectionMode::kFull && config.front_end.detector.refine_pattern &&
         config.set_up.rig.mounted_on == MountedOn::kBody && config.bodies.empty();
}

bool SearchesImages(const StreamOptions& options) {
  return !options.use_detections && options.measured == nullptr;
}

}  // namespace

Result<std::optional<Frame>> NextFrame(DataSource* source, const Rig& rig, SpanObserver* spans) {
  const Span span(spans, "read");
  auto frame = source->Next();
  if (!frame || !*frame) return frame;
  if (const auto fine = CheckImageSize(**frame, rig); !fine) return fine.error();
  for (const Frame& other : (*frame)->others) {
    if (const auto fine = CheckImageSize(other, rig); !fine) return fine.error();
  }
  return frame;
}

size_t FramesPerPiece(const Config& config, DetectionMode detection) {
  return IsSwept(config, detection) ? TagSweep::PieceLength(config.set_up.rig) : 1;
}

Result<MeasurementStream> MeasurementStream::Create(DataSource* source, const Config& config,
                                                    const StreamOptions& options) {
  const TagMap all_tags = config.AllTags();
  std::vector<CornerRefiner> refiners;
  for (const RigCamera& mounted : config.set_up.rig.cameras) {
    auto refiner = CornerRefiner::Create(all_tags, mounted.camera);
    if (!refiner) return refiner.error();
    refiners.push_back(std::move(*refiner));
  }
  auto shared =
      std::make_unique<const Shared>(Shared{config, all_tags, std::move(refiners), options});
  std::vector<Searcher> searchers(static_cast<size_t>(std::max(1, options.threads)));
  const TagDetectorOptions& look = config.front_end.detector;
  for (Searcher& searcher : searchers) {
    if (SearchesImages(options) && IsSwept(config, options.detection)) {
      for (size_t i = 0; i < shared->refiners.size(); ++i) {
        auto sweep = TagSweep::Create(SetUpOfCamera(config.set_up, i), look, shared->refiners[i]);
        if (!sweep) return sweep.error();
        searcher.sweeps.push_back(std::move(*sweep));
      }
    } else {
      auto detector = TagDetector::Create(config.set_up.map.family(), look);
      if (!detector) return detector.error();
      searcher.detector.emplace(std::move(*detector));
    }
  }
  return MeasurementStream(source, std::move(shared), std::move(searchers));
}

MeasurementStream::MeasurementStream(DataSource* source, std::unique_ptr<const Shared> shared,
                                     std::vector<Searcher> searchers)
    : source_(source), shared_(std::move(shared)), searchers_(std::move(searchers)) {
  for (const SetUp& set_up : shared_->config.SetUps()) {
    std::vector<FrontEnd>& of_body = front_ends_.emplace_back();
    for (size_t i = 0; i < set_up.rig.cameras.size(); ++i) {
      of_body.emplace_back(SetUpOfCamera(set_up, i), shared_->config.front_end);
    }
  }
}

SearchedFrame MeasurementStream::DetectOne(Frame frame, const Shared& shared,
                                           const Searcher& searcher) {
  const Config& config = shared.config;
  const TagDetectorOptions& look = config.front_end.detector;
  const auto index = static_cast<size_t>(frame.camera);
  const Camera& camera = config.set_up.rig.cameras.at(index).camera;
  SearchedFrame out;
  for (Frame& other : frame.others) {
    out.others.push_back(DetectOne(std::move(other), shared, searcher));
  }
  if (shared.options.measured != nullptr) {
    const auto tags = shared.options.measured->find(frame.t_ns);
    if (tags != shared.options.measured->end()) {
      out.tags = tags->second.tags;
      out.doubled_ids = tags->second.doubled_ids;
    }
  } else if (shared.options.use_detections) {
    out.tags = FilterTags(frame.detections, shared.all_tags, camera, look.border_px);
    out.doubled_ids = DoubledIdsOf(frame, shared.all_tags);
  } else {
    out.tags = FindTags(frame.image, *searcher.detector, shared.refiners[index], shared.all_tags,
                        camera, look, &out.doubled_ids);
  }
  for (TagDetection& tag : out.tags) tag.camera = frame.camera;
  out.frame = std::move(frame);
  return out;
}

// Each camera's images by themselves.
MeasurementStream::Piece MeasurementStream::Sweep(std::vector<Frame> frames,
                                                  std::vector<TagSweep>* sweeps) {
  Piece out;
  std::vector<std::vector<SweepImage>> images(sweeps->size());
  const auto take = [&](Frame&& frame) {
    images[static_cast<size_t>(frame.camera)].push_back({frame.t_ns, frame.image});
    SearchedFrame searched;
    searched.frame = std::move(frame);
    return searched;
  };
  for (Frame& frame : frames) {
    std::vector<Frame> others = std::move(frame.others);
    out.push_back(take(std::move(frame)));
    for (Frame& other : others) out.back().others.push_back(take(std::move(other)));
  }
  std::vector<std::vector<SweptTags>> found;
  for (size_t i = 0; i < sweeps->size(); ++i) found.push_back((*sweeps)[i].Find(images[i]));
  std::vector<size_t> next(sweeps->size());
  const auto give = [&](SearchedFrame* searched) {
    const auto camera = static_cast<size_t>(searched->frame.camera);
    SweptTags& swept = found[camera][next[camera]++];
    searched->tags = std::move(swept.tags);
    searched->doubled_ids = std::move(swept.doubled_ids);
    for (TagDetection& tag : searched->tags) tag.camera = searched->frame.camera;
  };
  for (SearchedFrame& searched : out) {
    give(&searched);
    for (SearchedFrame& other : searched.others) give(&other);
  }
  return out;
}

MeasurementStream::Piece MeasurementStream::Detect(std::vector<Frame> frames, const Shared& shared,
                                                   Searcher* searcher) {
  const Span span(shared.options.spans, "detect");
  const Stopwatch watch;
  Piece out;
  if (searcher->sweeps.empty()) {
    for (Frame& frame : frames) out.push_back(DetectOne(std::move(frame), shared, *searcher));
  } else {
    out = Sweep(std::move(frames), &searcher->sweeps);
  }
  const double share_ms = watch.ElapsedMs() / static_cast<double>(out.size());
  for (SearchedFrame& frame : out) frame.detect_ms = share_ms;
  return out;
}

// Fewer frames, or none, at the recording's end.
std::vector<Frame> MeasurementStream::ReadPiece() {
  const StreamOptions& options = shared_->options;
  const size_t most =
      SearchesImages(options) ? FramesPerPiece(shared_->config, options.detection) : 1;
  std::vector<Frame> out;
  while (!at_end_ && out.size() < most) {
    at_end_ = true;
    if (n_read_ == options.max_frames) break;
    auto frame = NextFrame(source_, shared_->config.set_up.rig, options.spans);
    if (!frame) end_ = frame.error();
    if (!frame || !*frame) break;
    if (!first_ns_) first_ns_ = (*frame)->t_ns;
    if ((*frame)->t_ns - *first_ns_ > options.duration_ns) break;
    at_end_ = false;
    ++n_read_;
    out.push_back(std::move(**frame));
  }
  return out;
}

void MeasurementStream::FillQueue() {
  // One piece under way a searcher; with a single thread each is measured when it is asked for.
  const auto policy = searchers_.size() > 1 ? std::launch::async : std::launch::deferred;
  while (!at_end_ && queue_.size() < searchers_.size()) {
    auto frames = ReadPiece();
    if (frames.empty()) break;
    Searcher* const searcher = &searchers_[next_searcher_];
    next_searcher_ = (next_searcher_ + 1) % searchers_.size();
    queue_.push_back(std::async(
        policy, [frames = std::move(frames), searcher, shared = shared_.get()]() mutable {
          return Detect(std::move(frames), *shared, searcher);
        }));
  }
}

Result<std::optional<SearchedFrame>> MeasurementStream::NextDetected() {
  FillQueue();
  if (ready_.empty() && queue_.empty()) {
    if (!end_) return end_.error();
    return std::optional<SearchedFrame>();
  }
  if (deadline_ != nullptr) deadline_->Start();
  if (ready_.empty()) {
    for (SearchedFrame& frame : queue_.front().get()) ready_.push_back(std::move(frame));
    queue_.pop_front();
  }
  std::optional<SearchedFrame> out = std::move(ready_.front());
  ready_.pop_front();
  return out;
}

DetectedFrame MeasurementStream::TakeSeenOf(size_t body, SearchedFrame* searched) const {
  const Config& config = shared_->config;
  DetectedFrame out;
  out.t_ns = searched->frame.t_ns;
  out.camera = searched->frame.camera;
  // Tracks are of what stands: of a camera that moves, about the tags that stand.
  if (config.set_up.rig.mounted_on == MountedOn::kBody && body == 0) {
    out.image = searched->frame.image;
  }
  if (config.bodies.empty()) {
    out.tags = std::move(searched->tags);
    out.doubled_ids = std::move(searched->doubled_ids);
    return out;
  }
  const TagMap& map = body == 0 ? config.set_up.map : config.bodies[body - 1].map;
  std::partition_copy(searched->tags.begin(), searched->tags.end(), std::back_inserter(out.tags),
                      std::back_inserter(out.besides.moving_tags),
                      [&](const TagDetection& tag) { return map.Find(tag.id) != nullptr; });
  std::copy_if(searched->doubled_ids.begin(), searched->doubled_ids.end(),
               std::back_inserter(out.doubled_ids),
               [&](int id) { return map.Find(id) != nullptr; });
  return out;
}

MeasuredFrame MeasurementStream::Measure(SearchedFrame* searched, size_t tags_elsewhere) {
  const Frame& frame = searched->frame;
  const auto camera = static_cast<size_t>(frame.camera);
  MeasuredFrame out;
  out.detect_ms = searched->detect_ms;
  out.images.push_back({frame.camera, frame.image});
  if (!frame.image_problem.empty()) out.image_problem = frame.name + ": " + frame.image_problem;
  OnlineOptions options;
  options.spans = shared_->options.spans;
  if (deadline_ != nullptr) options.detection_time_up = deadline_->ForDetection();
  Stopwatch watch;
  options.after_stage = [&](FrameStage stage) {
    (stage == FrameStage::kTrack ? out.track_ms : out.seed_ms) += watch.ElapsedMs();
    watch = Stopwatch();
  };
  DetectedFrame seen = TakeSeenOf(0, searched);
  seen.besides.tags_elsewhere = tags_elsewhere;
  out.measurements = MeasureFrame(std::move(seen), options, front_ends_.data());
  for (size_t body = 1; body < front_ends_.size(); ++body) {
    out.of_others.push_back(
        MeasureFrame(TakeSeenOf(body, searched), options, &front_ends_[body][camera]));
  }
  return out;
}

Result<std::optional<MeasuredFrame>> MeasurementStream::Next() {
  auto next = NextDetected();
  if (!next) return next.error();
  if (!*next) return std::optional<MeasuredFrame>();
  size_t n_tags = (*next)->tags.size();
  for (const SearchedFrame& other : (*next)->others) n_tags += other.tags.size();
  const auto elsewhere = [n_tags](const SearchedFrame& one) { return n_tags - one.tags.size(); };
  MeasuredFrame out = Measure(&**next, elsewhere(**next));
  for (SearchedFrame& other : (*next)->others) Merge(Measure(&other, elsewhere(other)), &out);
  return std::optional<MeasuredFrame>(std::move(out));
}

}  // namespace tagtwist::internal
