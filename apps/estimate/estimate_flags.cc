#include "apps/estimate/estimate_flags.h"

#include <gflags/gflags.h>

#include <algorithm>
#include <cmath>
#include <thread>

#include "apps/estimate/part_flags.h"
#include "apps/estimate/publish_flags.h"
#include "apps/support/config_flags.h"
#include "frontend/base/option_check.h"

DEFINE_string(dataset, "",
              "Recording: a video, a ROS 1 bag, a course .mat, an EuRoC/ASL folder, a plain folder "
              "(timestamps.csv and images), or a folder of images with stamps for names; or "
              "camera:0, camera:/dev/video0, camera:URL (window). Needed.");
DEFINE_string(topic, "", "Of the images in a ROS bag; the only one that has any where left out.");
DEFINE_string(ground_truth, "",
              "Poses to compare with: CSV, TUM, EuRoC or a course .mat. The recording's own where "
              "it has any.");
DEFINE_string(
    truth_topic, "",
    "Of the ground truth: a topic of a ROS bag, or a body of a motion capture's file; the "
    "only one where left out.");
DEFINE_bool(use_detections, false,
            "Tag corners come from the recording (detections.csv, .mat), not from its images.");
DEFINE_bool(imu, false, "With the recording's IMU, as the config's section imu says.");
DEFINE_string(output, "results", "Folder to write to; made where it is missing.");
DEFINE_string(
    fail_on, "none",
    "Exit status 3 where a run that is done has warnings, or also findings: none, warnings, "
    "findings. Results are written all the same.");
DEFINE_bool(write_covariance, false, "Also covariance.csv: the 12 x 12 of every frame.");
DEFINE_bool(
    write_detections, false,
    "Also detections.csv: the corners as they were measured, with their covariances, so that "
    "the run can be repeated without images (without tracks).");
DEFINE_string(
    overlay, "",
    "Also a video, .mp4 or .avi, that shows on each image its tags, tracks, the map where "
    "the state puts it, and the state in a line.");
DEFINE_string(profile, "",
              "Also what the run spends its time on, stage by stage and thread by thread, in the "
              "JSON that Perfetto and chrome://tracing open.");
DEFINE_bool(calibrate, false,
            "Refine map, lens and, against ground truth, mount, print scale and clock (of several "
            "cameras mounts and clocks), estimate with that, write it to calibration.yaml.");
DEFINE_bool(map_unknown_tags, false,
            "First place the tags that are seen and the map lacks, and write it with them to "
            "map.yaml.");
DEFINE_double(unknown_tag_size_m, 0,
              "Side of their black squares; 0: that of the map's tags, if they have one size.");
DEFINE_bool(sliding_window, false,
            "Online: a fixed-lag window, states at lag 0 and at its lag, instead of one batch.");
DEFINE_string(detection, "auto",
              "How tags are found: full: each image is searched; guided (window): each tag is "
              "fitted where the window predicts it, images are searched at the start, after loss "
              "and part by part now and then; auto: guided in the window; in a batch tags are "
              "followed through pieces of the recording, whose images are searched at the start "
              "and where something is out of place.");
DEFINE_bool(
    realtime, false,
    "The recording is played as if live: frames come when their stamps say, and are dropped "
    "where the estimate cannot keep up (window).");
DEFINE_string(stream, "",
              "Each frame's row of states.csv as soon as it is known (window): to a file, a FIFO, "
              "or, -, to standard output, which then has nothing else.");
DEFINE_double(deadline_ms, 0,
              "Time for a frame from when it is taken up [ms] (window, not --detection full): when "
              "it nears, what is known by then is the answer; 0: none.");
DEFINE_int32(max_frames, 0, "Ends after so many frames; 0: all.");
DEFINE_double(duration, 0, "Ends so long after the first frame [s]; 0: all.");
DEFINE_bool(
    tracks, true,
    "Points followed through the images help where tags are few; overrides the config. With "
    "--use_detections and without tracks no image is read.");
DEFINE_int32(window_frames, 0, "Frames in the window; 0: the config's.");
DEFINE_double(
    corner_sigma_px, 0,
    "Noise of a tag corner's coordinate [px]; 0: the config's, or learned from the data.");
DEFINE_string(clock, "",
              "When frames were taken: stamps, steady (a steady clock fitted to the stamps), or "
              "auto: steady where the images say so clearly (batch only); empty: the config's.");
DEFINE_double(track_sigma_px, 0,
              "Noise of a track's coordinate [px]; 0: the config's, or learned.");
DEFINE_double(
    accel_psd, 0,
    "Density of the white noise on acceleration [(m/s^2)^2/Hz]; 0: the config's, or learned.");
DEFINE_double(
    angular_accel_psd, 0,
    "Density of the white noise on angular acceleration [(rad/s^2)^2/Hz]; 0: the config's, or "
    "learned.");
DEFINE_double(jerk_psd, 0,
              "Density of the white noise on jerk [(m/s^3)^2/Hz]; 0: the config's, or learned.");
DEFINE_double(
    angular_jerk_psd, 0,
    "Density of the white noise on angular jerk [(rad/s^3)^2/Hz]; 0: the config's, or learned.");
DEFINE_string(
    motion_prior, "",
    "What of the motion is white noise: acceleration, jerk, or auto: what a given density "
    "says, else jerk with some acceleration, in batch the likelier; empty: the config's.");
DEFINE_int32(threads, 0,
             "Images measured at once; 0: as many as the machine has cores. Results do not depend "
             "on it.");

namespace tagtwist::internal {
namespace {

// A density or sigma from its flag; 0 leaves the config's.
Status Override(const char* flag, double value, std::optional<double>* out) {
  if (value == 0) return Ok();
  if (!(value > 0)) {
    return Error{std::string("--") + flag + ": expected > 0, got " + std::to_string(value)};
  }
  *out = value;
  return Ok();
}

// An option from the name that its flag gives; none leaves the config's.
template <typename Option>
Status Choose(const char* flag, const std::string& name, Option* out) {
  if (name.empty()) return Ok();
  const auto option = ValueOf<Option>(name);
  if (!option) {
    return Error{std::string("--") + flag + ": expected " + NamesOf<Option>() + ", got '" + name +
                 "'"};
  }
  *out = *option;
  return Ok();
}

Status LiveFromFlags(EstimateJob* job) {
  const bool is_camera = IsCamera(FLAGS_dataset);
  const std::string flag = is_camera ? "--dataset: a camera" : "--realtime:";
  job->realtime = FLAGS_realtime;
  if (!is_camera && !FLAGS_realtime) return Ok();
  if (!FLAGS_sliding_window) return Error{flag + " needs --sliding_window"};
  if (FLAGS_calibrate) return Error{flag + " excludes --calibrate"};
  if (FLAGS_map_unknown_tags) return Error{flag + " excludes --map_unknown_tags"};
  if (!FLAGS_overlay.empty()) return Error{flag + " excludes --overlay"};
  if (!is_camera) return Ok();
  if (FLAGS_realtime) return Error{flag + " excludes --realtime"};
  if (FLAGS_use_detections) return Error{flag + " excludes --use_detections"};
  if (!FLAGS_ground_truth.empty()) return Error{flag + " excludes --ground_truth"};
  return Ok();
}

Status StreamAndLimitsFromFlags(RunOptions* run) {
  if (!FLAGS_stream.empty() && !FLAGS_sliding_window) {
    return Error{"--stream: needs --sliding_window"};
  }
  if (const auto problem =
          FirstFlagProblem({CheckRange("max_frames", FLAGS_max_frames, 0, 1e9),
                            CheckRange("duration", FLAGS_duration, 0, 1e9),
                            CheckRange("deadline_ms", FLAGS_deadline_ms, 0, 1e6)})) {
    return Error{*problem};
  }
  if (FLAGS_deadline_ms > 0 && !FLAGS_sliding_window) {
    return Error{"--deadline_ms: needs --sliding_window"};
  }
  if (FLAGS_deadline_ms > 0 && FLAGS_detection == "full") {
    return Error{"--deadline_ms: excludes --detection full"};
  }
  if (FLAGS_deadline_ms > 0) run->deadline_ms = FLAGS_deadline_ms;
  if (FLAGS_max_frames > 0) run->max_frames = static_cast<size_t>(FLAGS_max_frames);
  if (FLAGS_duration > 0) run->duration_ns = std::llround(1e9 * FLAGS_duration);
  return Ok();
}

Result<DetectionMode> DetectionFromFlags() {
  if (FLAGS_detection == "auto") return DetectionMode::kAuto;
  if (FLAGS_detection == "full") return DetectionMode::kFull;
  if (FLAGS_detection != "guided") {
    return Error{"--detection: expected auto, full or guided, got \"" + FLAGS_detection + "\""};
  }
  if (!FLAGS_sliding_window) return Error{"--detection: guided needs --sliding_window"};
  if (FLAGS_use_detections) return Error{"--detection: guided needs images, not --use_detections"};
  return DetectionMode::kGuided;
}

}  // namespace

Usage EstimateUsage() {
  Usage usage;
  usage.program = "tagtwist_estimate";
  usage.synopsis = "--dataset PATH [--config FILE] [--output DIR] [...]";
  usage.summary =
      "Estimates pose and twist of a body whose camera sees AprilTags of known layout, each with\n"
      "its covariance, and compares the closed form with the optimised trajectory. Writes\n"
      "optimised.tum, closed_form.tum, states.csv, summary.json and report.html (open it in a\n"
      "browser).";
  usage.groups = {
      {"What to read",
       {"dataset", "topic", "ground_truth", "truth_topic", "use_detections", "imu", "realtime",
        "max_frames", "duration", "from", "to", "pieces"}},
      ConfigFlags(),
      {"What to write",
       {"output", "write_covariance", "write_detections", "only_detections", "overlay", "profile"}},
      {"While it runs", {"page", "listen", "publish", "record", "stream"}},
      {"How to estimate",
       {"calibrate", "map_unknown_tags", "unknown_tag_size_m", "sliding_window", "window_frames",
        "deadline_ms", "detection", "tracks", "clock"}},
      {"Noise (learned from the data unless given)",
       {"corner_sigma_px", "track_sigma_px", "motion_prior", "accel_psd", "angular_accel_psd",
        "jerk_psd", "angular_jerk_psd"}},
      {"Running", {"threads", "fail_on", "limits"}}};
  usage.implied = {{"page", "8765"}};
  usage.repeated = {"publish"};
  usage.examples = {
      {"A video of tags on a board, the camera calibrated by Kalibr",
       "tagtwist_estimate --dataset flight.mp4 --camera_file camchain.yaml --map april_6x6.yaml"},
      {"What the camera saw and what was made of it",
       "tagtwist_estimate --dataset flight --config course.yaml --overlay flight.mp4"},
      {"Online, a row a frame, from the first camera of the machine",
       "tagtwist_estimate --dataset camera:0 --config mine.yaml --sliding_window --stream -"},
      {"The same with a page to watch, for a robot and for Foxglove",
       "tagtwist_estimate --dataset camera:0 --config mine.yaml --sliding_window --page "
       "--publish udp://robot:9000 --publish foxglove"},
      {"When map, lens or mount cannot be trusted",
       "tagtwist_estimate --dataset flight --config mine.yaml --calibrate"}};
  return usage;
}

Result<EstimateJob> EstimateJobFromFlags() {
  EstimateJob job;
  if (FLAGS_dataset.empty()) return Error{"--dataset: needed, and not given"};
  if (FLAGS_output.empty()) return Error{"--output: expected a folder, got nothing"};
  if (const auto problem =
          FirstFlagProblem({CheckRange("threads", FLAGS_threads, 0, 1e4),
                            CheckRange("unknown_tag_size_m", FLAGS_unknown_tag_size_m, 0, 1e3)})) {
    return Error{*problem};
  }
  if (FLAGS_window_frames != 0 && !FLAGS_sliding_window) {
    return Error{"--window_frames: needs --sliding_window"};
  }
  if (FLAGS_unknown_tag_size_m != 0 && !FLAGS_map_unknown_tags) {
    return Error{"--unknown_tag_size_m: needs --map_unknown_tags"};
  }
  if (FLAGS_fail_on == "warnings") {
    job.fail_on = Outcome::kWarnings;
  } else if (FLAGS_fail_on == "findings") {
    job.fail_on = Outcome::kFindings;
  } else if (FLAGS_fail_on != "none") {
    return Error{"--fail_on: expected none, warnings or findings, got " + FLAGS_fail_on};
  }
  job.dataset = FLAGS_dataset;
  const auto config = ConfigFilesFromFlags();
  if (!config) return config.error();
  job.config = *config;
  job.output = FLAGS_output;
  job.topic = FLAGS_topic;
  job.truth_topic = FLAGS_truth_topic;
  job.ground_truth = FLAGS_ground_truth;
  job.overlay = FLAGS_overlay;
  job.profile = FLAGS_profile;
  job.stream = FLAGS_stream;
  job.read_images = FLAGS_tracks || !FLAGS_use_detections;
  job.write_covariance = FLAGS_write_covariance;
  job.write_detections = FLAGS_write_detections;
  job.calibrate = FLAGS_calibrate;
  job.map_unknown_tags = FLAGS_map_unknown_tags;
  job.unknown_tag_size_m = FLAGS_unknown_tag_size_m;
  job.run.sliding_window = FLAGS_sliding_window;
  job.run.use_detections = FLAGS_use_detections;
  job.run.use_imu = FLAGS_imu;
  auto detection = DetectionFromFlags();
  if (!detection) return detection.error();
  job.run.detection = *detection;
  if (const auto fine = LiveFromFlags(&job); !fine) return fine.error();
  if (const auto fine = StreamAndLimitsFromFlags(&job.run); !fine) return fine.error();
  if (const auto fine = PartFromFlags(&job); !fine) return fine.error();
  const auto publish = PublishFromFlags(job, FLAGS_realtime || IsCamera(FLAGS_dataset));
  if (!publish) return publish.error();
  job.publish = publish->options;
  if (!publish->csv.empty()) job.stream = publish->csv;
  const int cores = std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
  job.run.threads = FLAGS_threads > 0 ? FLAGS_threads : cores;
  return job;
}

Status OverrideOptions(EstimatorOptions* options) {
  for (const auto& status :
       {Override("corner_sigma_px", FLAGS_corner_sigma_px, &options->corner_sigma_px),
        Override("track_sigma_px", FLAGS_track_sigma_px, &options->track_sigma_px),
        Override("accel_psd", FLAGS_accel_psd, &options->accel_psd),
        Override("angular_accel_psd", FLAGS_angular_accel_psd, &options->angular_accel_psd),
        Override("jerk_psd", FLAGS_jerk_psd, &options->jerk_psd),
        Override("angular_jerk_psd", FLAGS_angular_jerk_psd, &options->angular_jerk_psd),
        Choose("motion_prior", FLAGS_motion_prior, &options->motion_prior),
        Choose("clock", FLAGS_clock, &options->clock)}) {
    if (!status) return status;
  }
  if (!gflags::GetCommandLineFlagInfoOrDie("tracks").is_default) options->use_tracks = FLAGS_tracks;
  if (FLAGS_window_frames != 0) options->window_frames = FLAGS_window_frames;
  if (const auto problem = options->Problem()) return Error{"--" + *problem};
  return Ok();
}

}  // namespace tagtwist::internal
