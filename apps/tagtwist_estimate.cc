#include <sys/resource.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>
#include <memory>
#include <opencv2/core/utility.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <optional>

#include "apps/estimate/calibrate/calibrate.h"
#include "apps/estimate/doubts.h"
#include "apps/estimate/estimate_flags.h"
#include "apps/estimate/inputs.h"
#include "apps/estimate/live_run.h"
#include "apps/estimate/outcome.h"
#include "apps/estimate/pieces.h"
#include "apps/estimate/profile.h"
#include "apps/estimate/rows.h"
#include "apps/estimate/sources.h"
#include "apps/support/clean_end.h"
#include "apps/support/guarded_main.h"
#include "estimator/calibration/gyro_alignment.h"
#include "estimator/imu/imu_solve.h"
#include "estimator/jobs/map_recording.h"
#include "estimator/jobs/overlay/overlay_recording.h"
#include "estimator/jobs/run.h"
#include "estimator/live/stopwatch.h"
#include "estimator/online/config.h"
#include "estimator/online/config_text.h"
#include "estimator/online/recording_options.h"
#include "estimator/report/result_writer.h"
#include "estimator/result/run_tally.h"
#include "frontend/base/files/file_set.h"
#include "frontend/base/printable.h"
#include "frontend/base/spans.h"

namespace tagtwist::internal {
namespace {

double PeakRssMib() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return static_cast<double>(usage.ru_maxrss) / 1024.0;  // Linux counts KiB
}

// Tags that the map lacks, told on standard output.
Result<Mapping> MapFirst(const EstimateJob& job, const Config& config) {
  MapJob mapping_job{job.dataset, job.topic, job.run.use_detections, job.run.threads, {}};
  mapping_job.mapping.tag_size_m = job.unknown_tag_size_m;
  auto mapping = MapUnknownTags(mapping_job, config);
  if (!mapping) return mapping;
  Messages(job) << mapping->map.tags().size() - config.set_up.map.tags().size()
                << " tags added to the map, " << mapping->left_out.size()
                << " seen and not placed\n\n";
  return mapping;
}

// Mount and clock of a gyro that the recording has, told on standard output.
std::shared_ptr<const GyroAlignment> AlignGyroTo(const EstimateJob& job, const Estimate& estimate,
                                                 const Config& config,
                                                 const std::vector<ImuSample>& imu) {
  std::vector<TimedRotation> camera;
  const Eigen::Quaterniond body_from_cam =
      config.set_up.rig.front().cam_from_body.rotation().conjugate();
  for (const FrameEstimate& frame : estimate.frames) {
    if (frame.status == FrameStatus::kNoFix) continue;
    camera.push_back({frame.t_ns, frame.state.world_from_body.rotation() * body_from_cam});
  }
  const auto gyro = AlignGyro(camera, imu);
  Messages(job) << (gyro ? GyroText(*gyro) : gyro.error().message) << "\n\n";
  return gyro ? std::make_shared<const GyroAlignment>(*gyro) : nullptr;
}

// What summary.json says of where a run comes from.
void RememberInputs(const EstimateJob& job, const Config& config, const Inputs& taken,
                    RunFacts* facts) {
  facts->dataset = job.dataset;
  facts->inputs = InputFilesOf(job);
  facts->taken = taken.lines;
  facts->configuration = ConfigurationText(config);
}

// What each of several bodies could not have, and how many states it has. Tags that move are not
// in the report's picture of the map.
void TakeBodies(const EstimateJob& job, const Config& config, std::vector<BodyEstimate> of_others,
                ResultContext* to) {
  to->map = config.set_up.map;
  to->map_moves = config.set_up.rig.mounted_on == MountedOn::kWorld;
  to->body = config.body;
  to->of_others = std::move(of_others);
  for (size_t i = 0; i < to->of_others.size(); ++i) {
    const BodyEstimate& other = to->of_others[i];
    const auto& all = to->facts.all_of_others;
    for (const std::string& warning : other.estimate.warnings) {
      std::cerr << "tagtwist_estimate: warning: " << other.name << ": " << Printable(warning)
                << "\n";
    }
    const RunTally tally = TallyOf(other.estimate, i < all.size() ? all[i].get() : nullptr);
    const size_t n = tally.frames.with_state;
    Messages(job) << other.name << ": " << n << " states\n";
  }
}

// What the run gives, with what its inputs and doubts say among its warnings. `lost`: why
// a file that states go to lacks some.
Result<RunResult> EstimateWatched(const EstimateJob& job, const Config& config, const Inputs& taken,
                                  RunOptions options, DataSource* source, ResultContext* context,
                                  std::unique_ptr<ResultRows>* rows, std::string* lost) {
  const Span span(job.run.spans, "estimate");
  TagSample sample;
  WriteAsTheyCome(job, rows->get(), &options);
  options.on_measurements = [&](const FrameMeasurements& frame) {
    sample.Add(frame);
    static_cast<void>((*rows)->AddMeasured(frame));  // told when the results are written
  };
  const bool goes_out = !job.stream.empty() || job.publish.IsAsked();
  auto run = goes_out ? RunAndPublish(job, source, config, options, lost)
                      : RunEstimate(job.dataset, source, config, options);
  const Doubts doubts = DoubtsOf(job, config, sample, context->truth,
                                 run ? &run->estimate : nullptr, run ? "" : run.error().message);
  RememberInputs(job, config, taken, &context->facts);
  if (!run) {
    rows->reset();
    return FailureOf(job, run.error(), taken, doubts, context->facts);
  }
  std::vector<std::string>& warnings = run->estimate.warnings;
  std::vector<std::string> first = taken.warnings;  // what is wrong as a whole before its traces
  for (const Fault& fault : doubts) {
    first.push_back(TextOf(fault));
    context->facts.doubts.push_back(fault.fact);
  }
  warnings.insert(warnings.begin(), first.begin(), first.end());
  if (run->facts.live) {
    std::cerr << "tagtwist_estimate: "
              << LiveText(*run->facts.live,
                          TallyOf(run->estimate, run->facts.all.get()).frames.frames)
              << "\n";
  }
  for (const std::string& warning : warnings) {
    std::cerr << "tagtwist_estimate: warning: " << Printable(warning) << "\n";
  }
  return run;
}

// What a run tells, beside what was known before.
void TakeFacts(RunFacts of_run, RunFacts* facts) {
  of_run.inputs = std::move(facts->inputs);
  of_run.taken = std::move(facts->taken);
  of_run.doubts = std::move(facts->doubts);
  of_run.configuration = std::move(facts->configuration);
  *facts = std::move(of_run);
}

// Everything between the flags and the last line printed. --tracks is of this run alone: what a
// calibration writes goes on with what the configuration said.
Status Run(const EstimateJob& job, Config config, bool configured_tracks, CleanEnd* end,
           Outcome* worst) {
  const Stopwatch watch;
  if (const auto fine = CheckRigOf(job, config); !fine) return fine;
  auto kept = CheckInputsAreKept(job, config);
  if (!kept) return kept.error();
  if (const auto writable = CheckOutputFolder(job.output); !writable) return writable;
  if (job.only_detections) return MeasurePiece(job, config);
  if (!job.overlay.empty()) {
    if (const auto fine = CheckOverlayOf(job, config); !fine) return fine;
  }
  ResultContext context;
  context.movable_tags = config.movable_tags;
  context.kept = std::move(*kept);
  if (job.map_unknown_tags) {
    auto mapping = MapFirst(job, config);
    if (!mapping) return mapping.error();
    config.set_up.map = mapping->map;
    context.mapping = std::make_shared<const Mapping>(std::move(*mapping));
  }
  auto source = OpenSource(job, config);
  if (!source) return source.error();
  auto taken = TakeInputs(job, config, **source);
  if (!taken) return taken.error();
  for (const std::string& line : taken->lines) Messages(job) << line << "\n";
  Messages(job) << "\n";
  context.truth = std::move(taken->truth);
  RunOptions options = job.run;
  if (const auto added = AddPieces(job, config, **source, &options); !added) return added;
  if (const auto done = CalibrateIfAsked(job, configured_tracks, &config, &*source, &context);
      !done) {
    RememberInputs(job, config, *taken, &context.facts);
    return FailureOf(job, done.error(), *taken, {}, context.facts);
  }
  if (job.realtime || IsCamera(job.dataset)) MakeLive(job, &*source, &options, end);
  auto rows = ResultRows::Begin(job.output, RowsOf(job, config));
  if (!rows) return rows.error();
  std::string lost;
  auto run = EstimateWatched(job, config, *taken, options, source->get(), &context, &*rows, &lost);
  if (!run) return run.error();
  const Estimate& estimate = run->estimate;
  if (job.calibrate && !(*source)->imu().empty()) {
    context.gyro = AlignGyroTo(job, estimate, config, (*source)->imu());
  }
  context.rows = CompareMethods(estimate, context.truth, {}, run->facts.all.get());
  context.write_covariance = job.write_covariance;
  TakeFacts(std::move(run->facts), &context.facts);
  TakeBodies(job, config, std::move(run->of_others), &context);
  context.facts.wall_s = 1e-3 * watch.ElapsedMs();
  context.facts.peak_rss_mib = PeakRssMib();
  if (const auto written = WriteResultsOf(job, std::move(*rows), estimate, context); !written)
    return written;
  if (estimate.imu) Messages(job) << TextOf(*estimate.imu) << "\n";
  *worst = TellResults(job, estimate, context, &Messages(job));
  if (!job.overlay.empty()) {
    if (const auto drawn = WriteOverlayOf(job, config, estimate); !drawn) return drawn;
  }
  return lost.empty() ? Ok() : Status(Error{lost});
}

int Main(int argc, char** argv, const Usage& usage) {
  ParseFlagsOrExit2(argc, argv, usage);
  auto job = EstimateJobFromFlags();
  if (!job) return Fail(usage, job.error().message, 2);
  CleanEnd end(usage, {{job->overlay, job->profile}, job->output});
  cv::setNumThreads(1);  // the frames are spread over threads here
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);  // quiet: faults are told in one line, by us
  auto config = LoadConfig(job->config);
  if (!config) return Fail(usage, config.error().message);
  if (const auto given = CheckMapIsGiven(*job, *config); !given) {
    return Fail(usage, given.error().message);
  }
  const bool configured_tracks = config->estimator.use_tracks;
  if (const auto overridden = OverrideOptions(&config->estimator); !overridden) {
    return Fail(usage, overridden.error().message, 2);
  }
  Outcome worst = Outcome::kClean;
  const auto done = WithProfile(job->profile, [&](SpanObserver* spans) {
    job->run.spans = spans;
    return Run(*job, *config, configured_tracks, &end, &worst);
  });
  if (!done) return Fail(usage, done.error().message);
  return worst >= job->fail_on ? 3 : 0;
}

}  // namespace
}  // namespace tagtwist::internal

int main(int argc, char** argv) {
  return tagtwist::internal::GuardedMain(argc, argv, tagtwist::internal::EstimateUsage,
                                         tagtwist::internal::Main);
}
