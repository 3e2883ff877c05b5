#include "apps/estimate/sources.h"

#include <iostream>
#include <utility>

#include "estimator/jobs/overlay/overlay_recording.h"
#include "estimator/live/live_feed.h"
#include "estimator/online/recording_options.h"
#include "frontend/base/spans.h"

namespace tagtwist::internal {

DataSourceOptions SourceOptions(const EstimateJob& job, const Config& config) {
  DataSourceOptions options{job.run.use_detections, job.read_images, {}, {}};
  if (!job.map_unknown_tags) {
    options = RecordingOptions(config, job.run.use_detections, job.read_images);
  }
  options.limits = config.limits;
  options.topic = job.topic;
  if (job.ground_truth.empty()) options.truth_topic = job.truth_topic;
  return options;
}

// What works with a camera that moves, or with the tags of one body.
Status CheckStanding(const EstimateJob& job, const Config& config) {
  struct Asked {
    bool is_asked;
    const char* flag;
  };
  const bool stands = config.set_up.rig.mounted_on == MountedOn::kWorld;
  const bool has_bodies = !config.bodies.empty() || !config.body.empty();
  for (const Asked& asked : std::vector<Asked>{
           {job.calibrate && (has_bodies || config.recordings.empty()), "--calibrate"},
           {job.map_unknown_tags, "--map_unknown_tags"},
           {!job.overlay.empty(), "--overlay"},
           {job.run.detection == DetectionMode::kGuided, "--detection guided"}}) {
    if (!asked.is_asked || !(stands || has_bodies)) continue;
    return Error{job.config.config + (stands ? ": cam_from_world: " : ": bodies: ") + asked.flag +
                 " is of a camera that moves over tags that stand"};
  }
  for (const Asked& asked :
       std::vector<Asked>{{job.write_detections, "--write_detections"},
                          {job.only_detections, "--only_detections"},
                          {!job.pieces.empty(), "--pieces"},
                          {config.estimator.clock == ClockChoice::kSteady, "--clock steady"}}) {
    if (!asked.is_asked || !has_bodies) continue;
    return Error{job.config.config + ": bodies: " + asked.flag + " is of the tags of one"};
  }
  return Ok();
}

Status CheckRigOf(const EstimateJob& job, const Config& config) {
  if (const auto fine = CheckStanding(job, config); !fine) return fine;
  if (config.recordings.empty()) return Ok();
  const auto refuse = [&](const std::string& flag) {
    return Error{job.config.config + ": cameras: " + flag +
                 " is of one camera: name it by camera and cam_from_body instead"};
  };
  if (job.map_unknown_tags) return refuse("--map_unknown_tags");
  if (!job.overlay.empty()) return refuse("--overlay");
  if (job.write_detections) return refuse("--write_detections");
  if (job.only_detections) return refuse("--only_detections");
  if (!job.pieces.empty()) return refuse("--pieces");
  if (!job.topic.empty()) return refuse("--topic");
  if (config.estimator.clock == ClockChoice::kSteady) return refuse("--clock steady");
  if (IsCamera(job.dataset)) return refuse("--dataset " + job.dataset);
  return Ok();
}

std::ostream& Messages(const EstimateJob& job) { return job.stream == "-" ? std::cerr : std::cout; }

namespace {

// The frames of a recording that the job takes.
Result<std::unique_ptr<DataSource>> OpenPart(const EstimateJob& job, const Config& config,
                                             const DataSourceOptions& options) {
  auto source = OpenRecording(job.dataset, config, options);
  if (!source || (!job.from && !job.to)) return source;
  const auto range = RangeOf(job.from, job.to, (*source)->stamps_ns().size());
  if (!range) return Error{job.dataset + ": " + range.error().message};
  return TakeRange(std::move(*source), *range);
}

}  // namespace

Result<std::unique_ptr<DataSource>> OpenSource(const EstimateJob& job, const Config& config) {
  return IsCamera(job.dataset) ? OpenCameraSource(job.dataset, config.set_up.rig.front().camera,
                                                  SteadyNowNs, config.limits)
                               : OpenPart(job, config, SourceOptions(job, config));
}

namespace {

OverlayOptions OverlayOptionsOf(const EstimateJob& job) {
  return {job.overlay, job.run.use_detections, job.run.threads};
}

// The recording once more, for its images.
Result<std::unique_ptr<DataSource>> OpenForOverlay(const EstimateJob& job, const Config& config) {
  DataSourceOptions options = SourceOptions(job, config);
  options.read_images = true;
  return OpenPart(job, config, options);
}

}  // namespace

Status CheckOverlayOf(const EstimateJob& job, const Config& config) {
  auto source = OpenForOverlay(job, config);
  if (!source) return source.error();
  return CheckOverlay(job.dataset, OverlayOptionsOf(job), source->get());
}

Status WriteOverlayOf(const EstimateJob& job, const Config& config, const Estimate& estimate) {
  auto source = OpenForOverlay(job, config);
  if (!source) return source.error();
  const Span span(job.run.spans, "overlay");
  const auto written = WriteOverlay(OverlayOptionsOf(job), config, estimate, source->get());
  if (written) Messages(job) << "overlay: " << job.overlay << "\n";
  return written;
}

}  // namespace tagtwist::internal
