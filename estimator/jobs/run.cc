#include "estimator/jobs/run.h"

#include <utility>

#include "estimator/batch/batch.h"
#include "estimator/jobs/measurement_stream.h"
#include "estimator/jobs/on_threads.h"
#include "estimator/jobs/online_run.h"
#include "estimator/jobs/recording_walk.h"
#include "estimator/jobs/stamp_error.h"
#include "estimator/live/stopwatch.h"
#include "estimator/online/imu/imu_feed.h"
#include "estimator/result/body_in_world.h"
#include "frontend/base/spans.h"

namespace tagtwist::internal {
namespace {

// All frames of the recording into the batch.
Status AddFrames(DataSource* source, const Config& config, const RunOptions& options,
                 RecordingWalk* walk, StageTimes* times, std::vector<BatchEstimator>* batches) {
  auto stream = MeasurementStream::Create(
      source, config,
      {options.use_detections, options.threads, options.detection, options.measured.get(),
       options.max_frames, options.duration_ns, options.spans});
  if (!stream) return stream.error();
  while (walk->HasRoom()) {
    const Span span(options.spans, "frame");
    auto frame = stream->Next();
    if (!frame) return frame.error();
    if (!*frame || !walk->Takes((*frame)->measurements.t_ns)) break;
    AddStageTimes(**frame, times);
    walk->Add((*frame)->image_problem, !(*frame)->measurements.tags.empty());
    if (options.on_measurements) options.on_measurements((*frame)->measurements);
    batches->front().Add(std::move((*frame)->measurements));
    for (size_t i = 1; i < batches->size(); ++i) {
      (*batches)[i].Add(std::move((*frame)->of_others[i - 1]));
    }
  }
  return Ok();
}

// Where a body has no estimate, one without frames whose warning says why: the others have theirs.
BodyEstimate SolveBody(const std::string& name, const BatchEstimator& batch) {
  BodyEstimate out{name, {}};
  auto estimate = batch.Solve();
  if (!estimate) {
    out.estimate.warnings.push_back(estimate.error().message);
    return out;
  }
  out.estimate = std::move(*estimate);
  out.estimate.trajectory = Trajectory();
  return out;
}

Result<RunResult> RunInBatch(const std::string& dataset, DataSource* source, const Config& config,
                             const RunOptions& options) {
  RunResult out;
  out.facts.dataset = dataset;
  RecordingWalk walk(dataset, source->stamps_ns().size(), options);
  std::vector<BatchEstimator> batches;
  for (const SetUp& set_up : config.SetUps()) {
    batches.emplace_back(set_up, config.estimator, OnThreads(options.threads), options.spans);
  }
  if (options.use_imu) {
    if (const Status fine = CheckImu(dataset, *source, config); !fine) return fine.error();
    batches.front().Use({config.imu, source->imu()});
  }
  const auto added = AddFrames(source, config, options, &walk, &out.facts.times, &batches);
  if (!added) return added.error();
  auto warnings = walk.Finish();
  if (!warnings) return warnings.error();
  const Stopwatch watch;
  auto estimate = batches.front().Solve();
  if (!estimate) return Error{dataset + ": " + estimate.error().message};
  for (size_t i = 1; i < batches.size(); ++i) {
    out.of_others.push_back(SolveBody(config.bodies[i - 1].name, batches[i]));
    if (config.set_up.rig.mounted_on == MountedOn::kBody) {
      PutInWorld(*estimate, &out.of_others.back().estimate);
    }
  }
  out.facts.times.optimise_ms = {watch.ElapsedMs()};
  out.estimate = std::move(*estimate);
  out.estimate.trajectory = Trajectory();
  out.estimate.warnings.insert(out.estimate.warnings.begin(), warnings->begin(), warnings->end());
  return out;
}

Result<RunResult> RunInWindow(const std::string& dataset, DataSource* source, const Config& config,
                              const RunOptions& options) {
  auto run = OnlineRun::Create(dataset, source, config, options);
  if (!run) return run.error();
  while (true) {
    const auto state = run->Next();
    if (!state) return state.error();
    if (*state == nullptr) return run->Finish();
  }
}

}  // namespace

Result<RunResult> RunEstimate(const std::string& dataset, DataSource* source, const Config& config,
                              const RunOptions& options) {
  return options.sliding_window
             ? RunInWindow(dataset, source, config, options)
             : RunInBatch(dataset, source, WithStampError(config, *source), options);
}

}  // namespace tagtwist::internal
