#include "estimator/jobs/run.h"

#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "estimator/batch/batch.h"
#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/on_threads.h"
#include "estimator/jobs/progress.h"
#include "estimator/live/stopwatch.h"
#include "estimator/online/config.h"
#include "estimator/online/online.h"
#include "estimator/window/rolling_shutter.h"
#include "estimator/window/sliding_window.h"

namespace tagtwist {
namespace {

// Bad images of a recording, told in one line.
struct ImageProblems {
  int count = 0;
  std::string first;

  void Add(const std::string& problem) {
    if (problem.empty()) return;
    if (count++ == 0) first = problem;
  }
  std::string Text() const {
    if (count == 1) return first + "; the frame's state comes from its neighbours";
    return first + "; so with " + std::to_string(count) + " images: their states come from others";
  }
};

// Feeds every frame of the recording to `add`; the stage times and warnings go to `estimate`.
template <typename AddFrame>
Status ForEachFrame(const std::string& dataset, DataSource* source, const RunOptions& options,
                    Result<MeasurementStream> stream, Estimate* estimate, AddFrame&& add) {
  if (!stream) return stream.error();
  std::optional<Progress> progress;
  if (options.progress) progress.emplace("estimating", source->stamps_ns().size());
  ImageProblems problems;
  size_t n_frames = 0;
  bool has_tags = false;
  std::optional<int64_t> first_ns;
  while (n_frames < options.max_frames) {
    auto next = stream->Next();
    if (!next) return next.error();
    if (!*next) break;
    MeasuredFrame& frame = **next;
    const int64_t t_ns = frame.measurements.t_ns;
    if (!first_ns) first_ns = t_ns;
    if (t_ns - *first_ns > options.duration_ns) break;
    StageTimes& times = estimate->times;
    times.detect_ms.push_back(frame.detect_ms);
    times.track_ms.push_back(frame.track_ms);
    times.seed_ms.push_back(frame.seed_ms);
    times.frame_ms.push_back(frame.detect_ms + frame.track_ms + frame.seed_ms);
    problems.Add(frame.image_problem);
    has_tags = has_tags || !frame.measurements.tags.empty();
    if (const auto added = add(std::move(frame.measurements)); !added) {
      return Error{dataset + ": frame " + std::to_string(n_frames) + ": " + added.error().message};
    }
    ++n_frames;
    if (progress) progress->Update(n_frames);
  }
  if (n_frames == 0) return Error{dataset + ": has no frame"};
  if (!has_tags) {
    if (problems.count > 0) return Error{problems.first + ", and no other frame shows a tag"};
    return Error{dataset + ": no frame shows a tag of the map"};
  }
  if (problems.count > 0) estimate->warnings.push_back(problems.Text());
  return Ok();
}

Result<Estimate> RunInBatch(const std::string& dataset, DataSource* source, const Config& config,
                            EstimatorSetup setup, const RunOptions& options) {
  Estimate estimate;
  estimate.mode = "batch";
  setup.for_ranges = OnThreads(options.threads);
  BatchEstimator batch(std::move(setup));
  const auto read = ForEachFrame(
      dataset, source, options,
      MeasurementStream::Create(source, config, options.use_detections, options.threads), &estimate,
      [&](FrameMeasurements measurements) {
        batch.Add(std::move(measurements));
        return Ok();
      });
  if (!read) return read.error();
  const Stopwatch watch;
  auto result = batch.Solve();
  if (result && config.line_time_s != 0) {
    batch.TakeTagsAsOfStamps(config.line_time_s, result->frames);
    result = batch.Solve();
  }
  if (!result) return Error{dataset + ": " + result.error().message};
  estimate.times.optimise_ms = {watch.ElapsedMs()};
  estimate.frames = std::move(result->frames);
  estimate.noise = result->noise;
  estimate.reprojection_px = std::move(result->reprojection_px);
  estimate.reprojection = std::move(result->reprojection);
  for (std::string& warning : result->warnings) estimate.warnings.push_back(std::move(warning));
  return estimate;
}

bool IsGuided(const Config& config, const RunOptions& options) {
  if (options.detection != DetectionMode::kAuto) return options.detection == DetectionMode::kGuided;
  return !options.use_detections && config.front_end.detector.refine_pattern;
}

Result<Estimate> RunInWindow(const std::string& dataset, DataSource* source, const Config& config,
                             const EstimatorSetup& setup, const RunOptions& options) {
  Estimate estimate;
  estimate.mode = "sliding_window";
  if (options.age_ms) estimate.live.emplace();
  SlidingWindow window(setup);
  std::optional<RollingShutterUndo> undo;
  if (config.line_time_s != 0) undo.emplace(setup, config.line_time_s);
  std::optional<FrameDeadline> deadline;
  if (options.deadline_ms) deadline.emplace(*options.deadline_ms);
  estimate.deadline_ms = options.deadline_ms;
  const auto add = [&](FrameMeasurements measurements) -> Status {
    const Stopwatch watch;
    if (undo) {
      auto undone =
          undo->AsOfStamp(std::move(measurements), deadline ? deadline->ForSolve() : TimeUp());
      if (!undone) return undone.error();
      measurements = std::move(*undone);
    }
    auto output = window.Add(measurements, deadline ? deadline->ForSolve() : TimeUp());
    if (!output) return output.error();
    estimate.times.optimise_ms.push_back(watch.ElapsedMs());
    estimate.times.frame_ms.back() += watch.ElapsedMs();
    if (options.age_ms) estimate.live->latency_ms.push_back(options.age_ms(measurements.t_ns));
    if (options.on_state) options.on_state(output->current);
    for (FrameEstimate& left : output->lagged) estimate.lagged.push_back(std::move(left));
    estimate.frames.push_back(std::move(output->current));
    estimate.reprojection_px.insert(estimate.reprojection_px.end(), output->reprojection_px.begin(),
                                    output->reprojection_px.end());
    return Ok();
  };
  const auto predict = [&](int64_t t_ns) { return PredictPose(window, t_ns); };
  auto measured =
      IsGuided(config, options)
          ? MeasurementStream::CreateGuided(source, config, predict)
          : MeasurementStream::Create(source, config, options.use_detections, options.threads);
  if (measured && deadline) measured->SetDeadline(&*deadline);
  const auto read = ForEachFrame(dataset, source, options, std::move(measured), &estimate, add);
  if (!read) return read.error();
  if (const auto fine = window.CheckSetUp(); !fine)
    return Error{dataset + ": " + fine.error().message};
  for (FrameEstimate& frame : window.Finish()) estimate.lagged.push_back(std::move(frame));
  estimate.noise = window.noise();
  estimate.reprojection = window.Reprojection();
  for (std::string& warning : window.Warnings()) estimate.warnings.push_back(std::move(warning));
  return estimate;
}

}  // namespace

Result<Estimate> RunEstimate(const std::string& dataset, DataSource* source, const Config& config,
                             const RunOptions& options) {
  const EstimatorSetup setup = SetupOf(config);
  return options.sliding_window ? RunInWindow(dataset, source, config, setup, options)
                                : RunInBatch(dataset, source, config, setup, options);
}

}  // namespace tagtwist
