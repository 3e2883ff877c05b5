#include "estimator/jobs/online_run.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/recording_walk.h"
#include "estimator/jobs/stamp_error.h"
#include "estimator/live/frame_deadline.h"
#include "estimator/live/stopwatch.h"
#include "estimator/online/imu/imu_feed.h"
#include "estimator/online/online_estimator.h"
#include "estimator/result/body_in_world.h"
#include "frontend/base/spans.h"

namespace tagtwist::internal {
namespace {

bool HasFix(const std::vector<FrameEstimate>& frames) {
  return std::any_of(frames.begin(), frames.end(), [](const FrameEstimate& frame) {
    return frame.status != FrameStatus::kNoFix;
  });
}

void KeepOutput(WindowOutput output, Estimate* estimate) {
  for (FrameEstimate& left : output.lagged) estimate->lagged.push_back(std::move(left));
  estimate->frames.push_back(std::move(output.current));
  estimate->reprojection_px.insert(estimate->reprojection_px.end(), output.reprojection_px.begin(),
                                   output.reprojection_px.end());
}

SeenBody SeenOf(const FrameMeasurements& measured, const WindowOutput& output) {
  return {output.current, measured.tags, output.used_tags, output.reprojection_px};
}

// What a window says when it is at its end.
void KeepEnd(OnlineEstimator* estimator, Estimate* estimate) {
  for (FrameEstimate& frame : estimator->Finish()) estimate->lagged.push_back(std::move(frame));
  const SlidingWindow& window = estimator->window();
  estimate->noise = window.noise();
  estimate->reprojection = window.Reprojection();
  estimate->cameras = window.Cameras();
  estimate->imu = window.Imu();
  for (std::string& warning : window.Warnings()) estimate->warnings.push_back(std::move(warning));
}

}  // namespace

std::vector<std::string> BodyNames(const Config& config) {
  std::vector<std::string> out = {config.body.empty() ? "body" : config.body};
  for (const TaggedBody& other : config.bodies) out.push_back(other.name);
  return out;
}

// It stays where it is: the estimator's options refer to it.
struct OnlineRun::Impl {
  Impl(const std::string& dataset, DataSource* from, const Config& with_config,
       const RunOptions& with_options)
      : source(from),
        config(WithStampError(with_config, *from)),
        imu(from->imu(), with_config.imu.time_offset_s),
        options(with_options),
        walk(dataset, from->stamps_ns().size(), with_options) {
    out.estimate.mode = EstimateMode::kSlidingWindow;
    out.facts.dataset = dataset;
    out.facts.deadline_ms = options.deadline_ms;
    if (options.age_ms) out.facts.live.emplace();
    if (options.deadline_ms) deadline.emplace(*options.deadline_ms);
  }

  OnlineOptions MakeOnlineOptions();
  Status MakeEstimator();
  void TakeTime(FrameStage stage);
  Result<std::optional<WindowOutput>> NextOfImage();
  Result<std::optional<WindowOutput>> NextOfStream();
  void Forget();
  void Keep(WindowOutput output);
  Status AddToOthers(std::vector<FrameMeasurements> measurements);

  OnlineFrame frame;
  DataSource* source;
  Config config;
  ImuFeed imu;
  RunOptions options;
  RecordingWalk walk;
  std::optional<FrameDeadline> deadline;
  Stopwatch since_last_stage;
  std::optional<OnlineEstimator> estimator;
  std::vector<OnlineEstimator> of_others;   // of Config::bodies
  std::optional<MeasurementStream> stream;  // where detection is not guided
  RunResult out;
};

OnlineOptions OnlineRun::Impl::MakeOnlineOptions() {
  OnlineOptions online;
  online.use_imu = options.use_imu;
  // Detections at hand need no search: what is in the stream is measured.
  const bool in_stream =
      options.use_detections || !config.set_up.rig.IsOneOnTheBody() || !config.bodies.empty();
  online.detection = in_stream && options.detection == DetectionMode::kAuto ? DetectionMode::kFull
                                                                            : options.detection;
  if (deadline) {
    online.detection_time_up = deadline->ForDetection();
    online.solve_time_up = deadline->ForSolve();
  }
  online.after_stage = [this](FrameStage stage) { TakeTime(stage); };
  online.spans = options.spans;
  return online;
}

Status OnlineRun::Impl::MakeEstimator() {
  auto made = OnlineEstimator::Create(config, MakeOnlineOptions());
  if (!made) return made.error();
  estimator.emplace(std::move(*made));
  const auto set_ups = config.SetUps();
  frame.bodies.resize(set_ups.size());
  for (size_t i = 1; i < set_ups.size(); ++i) {
    Config of_body = config;
    of_body.set_up = set_ups[i];
    OnlineOptions in_stream;
    in_stream.detection = DetectionMode::kFull;
    in_stream.spans = options.spans;
    auto other = OnlineEstimator::Create(of_body, in_stream);
    if (!other) return other.error();
    of_others.push_back(std::move(*other));
    out.of_others.push_back({config.bodies[i - 1].name, {}});
    out.of_others.back().estimate.mode = EstimateMode::kSlidingWindow;
  }
  if (estimator->is_guided()) return Ok();
  StreamOptions of_stream{options.use_detections, options.threads};
  of_stream.spans = options.spans;
  auto measured = MeasurementStream::Create(source, config, of_stream);
  if (!measured) return measured.error();
  stream.emplace(std::move(*measured));
  if (deadline) stream->SetDeadline(&*deadline);
  return Ok();
}

void OnlineRun::Impl::TakeTime(FrameStage stage) {
  StageTimes& times = out.facts.times;
  const double ms = since_last_stage.ElapsedMs();
  if (stage == FrameStage::kDetect) {
    times.detect_ms.push_back(ms);
    times.frame_ms.push_back(0);
  }
  if (stage == FrameStage::kTrack) times.track_ms.push_back(ms);
  if (stage == FrameStage::kClosedForm) times.seed_ms.push_back(ms);
  if (stage == FrameStage::kSolve) times.optimise_ms.push_back(ms);
  times.frame_ms.back() += ms;
  since_last_stage = Stopwatch();
}

Result<std::optional<WindowOutput>> OnlineRun::Impl::NextOfImage() {
  const auto taken = NextFrame(source, config.set_up.rig, options.spans);
  if (!taken) return taken.error();
  if (!*taken || !walk.Takes((*taken)->t_ns)) return std::optional<WindowOutput>();
  if (deadline) deadline->Start();
  since_last_stage = Stopwatch();
  if (options.use_imu) estimator->AddImu(imu.Until((*taken)->t_ns));
  auto output = estimator->AddImage((*taken)->t_ns, (*taken)->image);
  if (options.on_measurements) options.on_measurements(estimator->measurements());
  if (!output) return walk.OfFrame(output.error());
  frame.images = {{0, (*taken)->image}};
  const std::string& problem = (*taken)->image_problem;
  walk.Add(problem.empty() ? problem : (*taken)->name + ": " + problem,
           !estimator->measurements().tags.empty());
  return std::optional<WindowOutput>(std::move(*output));
}

Result<std::optional<WindowOutput>> OnlineRun::Impl::NextOfStream() {
  auto taken = stream->Next();
  if (!taken) return taken.error();
  if (!*taken || !walk.Takes((*taken)->measurements.t_ns)) return std::optional<WindowOutput>();
  AddStageTimes(**taken, &out.facts.times);
  since_last_stage = Stopwatch();
  if (options.on_measurements) options.on_measurements((*taken)->measurements);
  if (options.use_imu) estimator->AddImu(imu.Until((*taken)->measurements.t_ns));
  auto output = estimator->AddMeasurements(std::move((*taken)->measurements));
  if (!output) return walk.OfFrame(output.error());
  if (const auto added = AddToOthers(std::move((*taken)->of_others)); !added) {
    return walk.OfFrame(added.error());
  }
  frame.images = std::move((*taken)->images);
  walk.Add((*taken)->image_problem, !estimator->measurements().tags.empty());
  return std::optional<WindowOutput>(std::move(*output));
}

Status OnlineRun::Impl::AddToOthers(std::vector<FrameMeasurements> measurements) {
  for (size_t i = 0; i < of_others.size(); ++i) {
    auto output = of_others[i].AddMeasurements(std::move(measurements[i]));
    if (!output) return Error{out.of_others[i].name + ": " + output.error().message};
    frame.bodies[i + 1] = SeenOf(of_others[i].measurements(), *output);
    KeepOutput(std::move(*output), &out.of_others[i].estimate);
  }
  return Ok();
}

// What went before.
void OnlineRun::Impl::Forget() {
  out.facts.times = StageTimes();
  if (out.facts.live) out.facts.live->latency_ms.clear();
  const auto forget = [](Estimate* estimate) {
    estimate->frames.clear();
    estimate->lagged.clear();
    estimate->reprojection_px.clear();
  };
  forget(&out.estimate);
  for (BodyEstimate& other : out.of_others) forget(&other.estimate);
}

void OnlineRun::Impl::Keep(WindowOutput output) {
  Estimate& estimate = out.estimate;
  if (options.age_ms) {
    frame.age_ms = options.age_ms(output.current.t_ns);
    out.facts.live->latency_ms.push_back(frame.age_ms);
    if (options.frames_dropped) frame.frames_dropped = options.frames_dropped();
    out.facts.live->frames_dropped = frame.frames_dropped;
  }
  frame.bodies.front() = SeenOf(estimator->measurements(), output);
  if (config.set_up.rig.mounted_on == MountedOn::kBody) {
    for (size_t i = 1; i < frame.bodies.size(); ++i) {
      frame.bodies[i].state = BodyInWorld(output.current, frame.bodies[i].state);
    }
  }
  KeepOutput(std::move(output), &estimate);
}

Result<OnlineRun> OnlineRun::Create(const std::string& dataset, DataSource* source,
                                    const Config& config, const RunOptions& options) {
  if (options.use_imu) {
    if (const Status fine = CheckImu(dataset, *source, config); !fine) return fine.error();
  }
  auto impl = std::make_unique<Impl>(dataset, source, config, options);
  if (const auto made = impl->MakeEstimator(); !made) return made.error();
  return OnlineRun(std::move(impl));
}

OnlineRun::OnlineRun(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
OnlineRun::OnlineRun(OnlineRun&&) noexcept = default;
OnlineRun& OnlineRun::operator=(OnlineRun&&) noexcept = default;
OnlineRun::~OnlineRun() = default;

Result<const FrameEstimate*> OnlineRun::Next() {
  const FrameEstimate* const end = nullptr;
  if (!impl_->walk.HasRoom()) return end;
  if (!impl_->options.keeps_states) impl_->Forget();
  const Span span(impl_->options.spans, "frame");
  auto output = impl_->stream ? impl_->NextOfStream() : impl_->NextOfImage();
  if (!output) return output.error();
  if (!*output) return end;
  impl_->Keep(std::move(**output));
  const FrameEstimate* const state = &impl_->out.estimate.frames.back();
  return state;
}

const OnlineFrame& OnlineRun::frame() const { return impl_->frame; }

Result<RunResult> OnlineRun::Finish() {
  auto warnings = impl_->walk.Finish();
  if (!warnings) return warnings.error();
  if (const auto fine = impl_->estimator->window().CheckSetUp(); !fine) {
    return Error{impl_->out.facts.dataset + ": " + fine.error().message};
  }
  Estimate& estimate = impl_->out.estimate;
  estimate.warnings = std::move(*warnings);
  KeepEnd(&*impl_->estimator, &estimate);
  if (!HasFix(estimate.frames) && !HasFix(estimate.lagged)) {
    return Error{impl_->out.facts.dataset + ": no frame has a tag of the map that gives a pose"};
  }
  for (size_t i = 0; i < impl_->of_others.size(); ++i) {
    Estimate& other = impl_->out.of_others[i].estimate;
    KeepEnd(&impl_->of_others[i], &other);
    if (impl_->config.set_up.rig.mounted_on == MountedOn::kBody) PutInWorld(estimate, &other);
    if (HasFix(other.frames) || HasFix(other.lagged)) continue;
    other.warnings.emplace_back("no frame has a tag of it that gives a pose");
  }
  return std::move(impl_->out);
}

}  // namespace tagtwist::internal
