#include "apps/simulate/simulate_flags.h"

#include <gflags/gflags.h>

#include <array>
#include <cmath>
#include <utility>

#include "apps/support/config_flags.h"

namespace {
const tagtwist::internal::SimulateJob& Defaults() {
  static const tagtwist::internal::SimulateJob defaults;
  return defaults;
}
const tagtwist::SimulatorOptions& Sim() { return Defaults().simulator; }
const tagtwist::RendererOptions& Look() { return Sim().renderer; }
}  // namespace

DEFINE_string(output, "", "Folder (or .mat file) to write; must not exist, or be an empty folder.");
DEFINE_string(format, Defaults().format,
              "folder (timestamps.csv, images, ground_truth.csv, detections.csv, imu.csv), euroc "
              "(EuRoC/ASL: mav0/cam0/data.csv ...) or mat (the course's).");
DEFINE_bool(images, Sim().images, "Render images; without them detections alone are written.");
DEFINE_double(imu_rate, Sim().imu_rate_hz, "IMU samples a second; 0 for none.");
DEFINE_double(gyro_noise_radps, Sim().gyro_noise_radps,
              "Noise of a gyro sample, standard deviation [rad/s].");
DEFINE_double(accel_noise_mps2, Sim().accel_noise_mps2,
              "Noise of an accelerometer sample, standard deviation [m/s^2].");
DEFINE_double(gyro_bias_radps, Sim().gyro_bias_radps,
              "Constant bias of each axis, drawn with that standard deviation [rad/s].");
DEFINE_double(accel_bias_mps2, Sim().accel_bias_mps2,
              "Constant bias of each axis, drawn with that standard deviation [m/s^2].");
DEFINE_string(trajectory, Defaults().trajectory,
              "figure8, hover, circle, agile, straight, or a file of poses: ground_truth.csv "
              "columns by name, TUM, EuRoC. A spline smooths it and is the truth.");
DEFINE_string(image_times, Defaults().image_times,
              "CSV with a column t [s]: the frames' stamps, on the trajectory's clock.");
DEFINE_double(duration, Defaults().duration_s,
              "Seconds to render; 0: 20 s of a named flight, all of a file.");
DEFINE_double(height, Defaults().height_m, "Height of a named flight over the mat [m].");
DEFINE_double(rate, Defaults().rate_hz, "Frames a second, without --image_times.");
DEFINE_double(jitter_ms, 1e3 * Defaults().jitter_s, "Stamps move by up to this, either way [ms].");
DEFINE_uint64(seed, Sim().random_seed, "Of everything random. Same seed, same bytes.");
DEFINE_double(noise, Look().noise_grey, "Sensor noise, standard deviation [grey levels].");
DEFINE_double(blur_px, Look().blur_px, "Defocus, standard deviation of a Gaussian [px].");
DEFINE_double(exposure_ms, 1e3 * Sim().exposure_s,
              "Motion blur [ms]; stamps are the middle of the exposure.");
DEFINE_double(vignetting, Look().vignetting, "Share of light lost in the corners, 0 to 1.");
DEFINE_double(gradient, Look().gradient, "Illumination gradient across the image, 0 to 1.");
DEFINE_double(gradient_direction_deg, Look().gradient_direction_rad,
              "Where the image brightens: 0 to the right, 90 downwards.");
DEFINE_int32(supersampling, Look().supersampling, "Samples along a pixel's side, 1 to 16.");
DEFINE_double(scribble, Look().scene.scribbles_per_m2,
              "Strokes and blobs a square metre of floor and walls; 0 for bare ones.");
DEFINE_bool(floor, Look().scene.floor, "The floor z = 0 is there.");
DEFINE_bool(walls, Look().scene.walls,
            "Sheets carry the tags that are not on the floor, a tag's side beyond them, with "
            "scribble for the tracks.");
DEFINE_int32(occluders, Look().scene.occluders, "Dark or bright ellipses over the map.");
DEFINE_double(occluder_radius, Look().scene.occluder_radius_m, "Their mean radius [m].");
DEFINE_double(occluder_height, Look().scene.occluder_height_m, "They float up to this height [m].");
DEFINE_double(occluder_speed, Look().scene.occluder_speed_mps, "They swing up to this fast [m/s].");
DEFINE_double(line_time_s, Sim().line_time_s,
              "Rolling shutter: row v is taken this long times v after the stamp; without images.");
DEFINE_double(corner_noise_px, Sim().corner_noise_px,
              "Noise of the corners in detections.csv, standard deviation [px].");
DEFINE_double(hidden_fraction, Sim().hidden_fraction, "Share of visible tags not detected.");
DEFINE_double(wrong_id_fraction, Sim().wrong_id_fraction,
              "Share of detections that carry another tag's id.");
DEFINE_double(hide_tags_from, Sim().hide_tags_from_s,
              "From this stamp [s] on papers are blank and nothing is detected ...");
DEFINE_double(hide_tags_to, Sim().hide_tags_to_s, "... until this one.");
DEFINE_int32(threads, Defaults().threads,
             "Frames rendered at once; 0: as many as the machine has. The output does not depend "
             "on it.");

namespace tagtwist::internal {
namespace {

constexpr double kRadPerDeg = 3.14159265358979323846 / 180;

// The options' own names of what flags call differently.
constexpr std::array<std::pair<const char*, const char*>, 14> kFlagOfKey = {{
    {"noise_grey", "noise"},
    {"gradient_direction_rad", "gradient_direction_deg (in rad)"},
    {"exposure_s", "exposure_ms (in s)"},
    {"jitter_s", "jitter_ms (in s)"},
    {"rate_hz", "rate"},
    {"imu_rate_hz", "imu_rate"},
    {"scribbles_per_m2", "scribble"},
    {"occluder_radius_m", "occluder_radius"},
    {"occluder_height_m", "occluder_height"},
    {"occluder_speed_mps", "occluder_speed"},
    {"hide_tags_from_s", "hide_tags_from"},
    {"hide_tags_to_s", "hide_tags_to"},
    {"duration_s", "duration"},
    {"height_m", "height"},
}};

Error FlagError(const std::string& problem) {
  const size_t colon = problem.find(':');
  for (const auto& [key, flag] : kFlagOfKey) {
    if (problem.substr(0, colon) == key) {
      return Error{"--" + std::string(flag) + problem.substr(colon)};
    }
  }
  return Error{"--" + problem};
}

RendererOptions LookFromFlags() {
  RendererOptions out;
  out.noise_grey = FLAGS_noise;
  out.blur_px = FLAGS_blur_px;
  out.vignetting = FLAGS_vignetting;
  out.gradient = FLAGS_gradient;
  out.gradient_direction_rad = kRadPerDeg * FLAGS_gradient_direction_deg;
  out.supersampling = FLAGS_supersampling;
  out.scene.scribbles_per_m2 = FLAGS_scribble;
  out.scene.floor = FLAGS_floor;
  out.scene.walls = FLAGS_walls;
  out.scene.occluders = FLAGS_occluders;
  out.scene.occluder_radius_m = FLAGS_occluder_radius;
  out.scene.occluder_height_m = FLAGS_occluder_height;
  out.scene.occluder_speed_mps = FLAGS_occluder_speed;
  return out;
}

SimulatorOptions SimulatorFromFlags() {
  SimulatorOptions out;
  out.renderer = LookFromFlags();
  out.random_seed = FLAGS_seed;
  out.images = FLAGS_images;
  out.exposure_s = 1e-3 * FLAGS_exposure_ms;
  out.corner_noise_px = FLAGS_corner_noise_px;
  out.line_time_s = FLAGS_line_time_s;
  out.hidden_fraction = FLAGS_hidden_fraction;
  out.wrong_id_fraction = FLAGS_wrong_id_fraction;
  out.hide_tags_from_s = FLAGS_hide_tags_from;
  out.hide_tags_to_s = FLAGS_hide_tags_to;
  out.imu_rate_hz = FLAGS_imu_rate;
  out.gyro_noise_radps = FLAGS_gyro_noise_radps;
  out.accel_noise_mps2 = FLAGS_accel_noise_mps2;
  out.gyro_bias_radps = FLAGS_gyro_bias_radps;
  out.accel_bias_mps2 = FLAGS_accel_bias_mps2;
  return out;
}

}  // namespace

Usage SimulateUsage() {
  return {
      "tagtwist_simulate",
      "--output PATH [--trajectory NAME|FILE] [--image_times FILE] [...]",
      "Renders a flight over a map of AprilTags as a data set with exact ground truth (pose and\n"
      "twist at every frame's stamp), for tagtwist_estimate --dataset PATH.",
      {{"What to write",
        {"output", "format", "images", "imu_rate", "gyro_noise_radps", "accel_noise_mps2",
         "gyro_bias_radps", "accel_bias_mps2"}},
       {"The flight", {"trajectory", "image_times", "duration", "height", "rate", "jitter_ms"}},
       ConfigFlags(),
       {"The image",
        {"noise", "blur_px", "exposure_ms", "vignetting", "gradient", "gradient_direction_deg",
         "supersampling"}},
       {"The scene",
        {"scribble", "floor", "walls", "occluders", "occluder_radius", "occluder_height",
         "occluder_speed"}},
       {"Detections and faults",
        {"line_time_s", "corner_noise_px", "hidden_fraction", "wrong_id_fraction", "hide_tags_from",
         "hide_tags_to"}},
       {"Running", {"seed", "threads", "limits"}}},
      /*max_arguments=*/0,
      {{"A flight over the course's mat",
        "tagtwist_simulate --output flight --trajectory figure8 --duration 10"},
       {"A rehearsal with a camera and a map of one's own, half a metre up",
        "tagtwist_simulate --output flight --camera_file camchain.yaml --map mat.yaml --height "
        "0.5"}}};
}

Result<SimulateJob> SimulateJobFromFlags() {
  SimulateJob job;
  job.output = FLAGS_output;
  job.format = FLAGS_format;
  job.trajectory = FLAGS_trajectory;
  job.image_times = FLAGS_image_times;
  const auto config = ConfigFilesFromFlags();
  if (!config) return config.error();
  job.config = *config;
  job.duration_s = FLAGS_duration;
  job.height_m = FLAGS_height;
  job.rate_hz = FLAGS_rate;
  job.jitter_s = 1e-3 * FLAGS_jitter_ms;
  job.threads = FLAGS_threads;
  job.simulator = SimulatorFromFlags();
  if (job.output.empty()) return Error{"--output: expected a path"};
  if (const auto format = ParseFormat(job.format); !format) return format.error();
  if (const auto problem = job.Problem()) return FlagError(*problem);
  return job;
}

}  // namespace tagtwist::internal
