#include "estimator/jobs/online_run.h"

#include <optional>
#include <utility>

#include "estimator/jobs/kept/kept_states.h"
#include "estimator/jobs/kept/told_bodies.h"
#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/on_threads.h"
#include "estimator/jobs/recording_walk.h"
#include "estimator/jobs/stamp_error.h"
#include "estimator/live/frame_deadline.h"
#include "estimator/live/stopwatch.h"
#include "estimator/online/imu/imu_feed.h"
#include "estimator/online/online_estimator.h"
#include "frontend/base/spans.h"

namespace tagtwist::internal {
namespace {

SeenBody SeenOf(const FrameMeasurements& measured, const WindowOutput& output) {
  return {output.current, measured.tags, output.used_tags, output.reprojection_px};
}

std::string ImageProblemOf(const Frame& frame) {
  return frame.image_problem.empty() ? "" : frame.name + ": " + frame.image_problem;
}

// What a window says of itself when it is at its end.
void TakeEnd(const SlidingWindow& window, Estimate* estimate) {
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
        walk(dataset, from->stamps_ns().size(), with_options),
        times(with_options.most_kept, with_options.deadline_ms) {
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
  Status Tell(const WindowOutput& output);
  Status FinishBody(size_t body, OnlineEstimator* of_body, Estimate* estimate);
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
  std::vector<OnlineEstimator> of_others;    // of Config::bodies
  std::vector<WindowOutput> others_outputs;  // of the latest frame
  std::optional<ToldBodies> told;            // all of them
  StageTimes frame_times;                    // of the latest frame
  KeptTimes times;
  std::optional<MeasurementStream> stream;  // where detection is not guided
  RunResult out;
};

OnlineOptions OnlineRun::Impl::MakeOnlineOptions() {
  OnlineOptions online;
  online.use_imu = options.use_imu;
  // Detections at hand need no search: what is in the stream is measured.
  const bool in_stream = options.use_detections ||
                         config.set_up.rig.mounted_on != MountedOn::kBody || !config.bodies.empty();
  online.detection = in_stream && options.detection == DetectionMode::kAuto ? DetectionMode::kFull
                                                                            : options.detection;
  if (deadline) {
    online.detection_time_up = deadline->ForDetection();
    online.solve_time_up = deadline->ForSolve();
  }
  online.after_stage = [this](FrameStage stage) { TakeTime(stage); };
  online.spans = options.spans;
  if (config.set_up.rig.IsOfSeveral()) online.for_ranges = OnThreads(options.threads);
  return online;
}

Status OnlineRun::Impl::MakeEstimator() {
  auto made = OnlineEstimator::Create(config, MakeOnlineOptions());
  if (!made) return made.error();
  estimator.emplace(std::move(*made));
  const auto set_ups = config.SetUps();
  frame.bodies.resize(set_ups.size());
  told.emplace(set_ups.size(), config.set_up.rig.mounted_on == MountedOn::kBody, options);
  others_outputs.resize(set_ups.size() - 1);
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
  const double ms = since_last_stage.ElapsedMs();
  // Each camera of a rig tells of its own.
  const auto add = [ms](std::vector<double>* of_frame) {
    of_frame->resize(1);
    of_frame->back() += ms;
  };
  if (stage == FrameStage::kDetect) add(&frame_times.detect_ms);
  if (stage == FrameStage::kTrack) add(&frame_times.track_ms);
  if (stage == FrameStage::kClosedForm) add(&frame_times.seed_ms);
  if (stage == FrameStage::kSolve) add(&frame_times.optimise_ms);
  add(&frame_times.frame_ms);
  since_last_stage = Stopwatch();
}

Result<std::optional<WindowOutput>> OnlineRun::Impl::NextOfImage() {
  const auto taken = NextFrame(source, config.set_up.rig, options.spans);
  if (!taken) return taken.error();
  if (!*taken || !walk.Takes((*taken)->t_ns)) return std::optional<WindowOutput>();
  if (deadline) deadline->Start();
  since_last_stage = Stopwatch();
  if (options.use_imu) estimator->AddImu(imu.Until((*taken)->t_ns));
  frame.images = {{(*taken)->camera, (*taken)->image}};
  std::string problem = ImageProblemOf(**taken);
  for (const Frame& other : (*taken)->others) {
    frame.images.push_back({other.camera, other.image});
    if (problem.empty()) problem = ImageProblemOf(other);
  }
  auto output = estimator->AddImages((*taken)->t_ns, frame.images);
  if (options.on_measurements) options.on_measurements(estimator->measurements());
  if (!output) return walk.OfFrame(output.error());
  walk.Add(problem, !estimator->measurements().tags.empty());
  return std::optional<WindowOutput>(std::move(*output));
}

Result<std::optional<WindowOutput>> OnlineRun::Impl::NextOfStream() {
  auto taken = stream->Next();
  if (!taken) return taken.error();
  if (!*taken || !walk.Takes((*taken)->measurements.t_ns)) return std::optional<WindowOutput>();
  AddStageTimes(**taken, &frame_times);
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
    others_outputs[i] = std::move(*output);
  }
  return Ok();
}

// What is known of a frame, to those who are told and to what is kept.
Status OnlineRun::Impl::Tell(const WindowOutput& output) {
  if (options.age_ms) {
    frame.age_ms = options.age_ms(output.current.t_ns);
    times.AddLatency(frame.age_ms);
    if (options.frames_dropped) frame.frames_dropped = options.frames_dropped();
    out.facts.live->frames_dropped = frame.frames_dropped;
  }
  times.Add(frame_times);
  frame.bodies.front() = SeenOf(estimator->measurements(), output);
  if (const Status done = told->Tell(&frame.bodies); !done) return done;
  if (const Status done = told->TellLagged(0, output.lagged); !done) return done;
  for (size_t i = 0; i < others_outputs.size(); ++i) {
    if (const Status done = told->TellLagged(i + 1, others_outputs[i].lagged); !done) return done;
  }
  return Ok();
}

Status OnlineRun::Impl::FinishBody(size_t body, OnlineEstimator* of_body, Estimate* estimate) {
  if (const Status done = told->TellLagged(body, of_body->Finish()); !done) return done;
  TakeEnd(of_body->window(), estimate);
  return Ok();
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
  StageTimes& times = impl_->frame_times;
  for (auto* ms :
       {&times.detect_ms, &times.track_ms, &times.seed_ms, &times.optimise_ms, &times.frame_ms}) {
    ms->clear();
  }
  const Span span(impl_->options.spans, "frame");
  auto output = impl_->stream ? impl_->NextOfStream() : impl_->NextOfImage();
  if (!output) return output.error();
  if (!*output) return end;
  if (const Status done = impl_->Tell(**output); !done) return done.error();
  const FrameEstimate* const state = &impl_->frame.bodies.front().state;
  return state;
}

const OnlineFrame& OnlineRun::frame() const { return impl_->frame; }

Result<RunResult> OnlineRun::Finish() {
  auto warnings = impl_->walk.Finish();
  if (!warnings) return warnings.error();
  RunResult& out = impl_->out;
  if (const auto fine = impl_->estimator->window().CheckSetUp(); !fine) {
    return Error{out.facts.dataset + ": " + fine.error().message};
  }
  out.estimate.warnings = std::move(*warnings);
  const Status finished = impl_->FinishBody(0, &*impl_->estimator, &out.estimate);
  if (!finished) return finished.error();
  if (!impl_->told->kept(0).HasFix()) {
    return Error{out.facts.dataset + ": no frame has a tag of the map that gives a pose"};
  }
  out.facts.all = impl_->told->kept(0).MoveTo(&out.estimate);
  impl_->times.MoveTo(&out.facts);
  for (size_t i = 0; i < impl_->of_others.size(); ++i) {
    Estimate& other = out.of_others[i].estimate;
    const Status done = impl_->FinishBody(i + 1, &impl_->of_others[i], &other);
    if (!done) return done.error();
    const bool has_fix = impl_->told->kept(i + 1).HasFix();
    out.facts.all_of_others.push_back(impl_->told->kept(i + 1).MoveTo(&other));
    if (!has_fix) other.warnings.emplace_back("no frame has a tag of it that gives a pose");
  }
  return std::move(out);
}

}  // namespace tagtwist::internal
