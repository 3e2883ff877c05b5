#include "apps/estimate/inputs.h"

#include <algorithm>
#include <utility>

#include "estimator/online/camera_sections.h"
#include "estimator/online/config_text.h"
#include "estimator/report/files/corner_piece.h"
#include "estimator/report/result_set.h"
#include "frontend/base/files/run_files.h"
#include "frontend/base/format_text.h"
#include "frontend/base/statistics/quantile.h"
#include "frontend/io/trajectories/trajectory_file.h"
#include "frontend/types/lens/lens.h"

namespace tagtwist::internal {
namespace {

std::string SpanText(int64_t first_ns, int64_t last_ns) {
  return Format("%.3f to %.3f s", ToSeconds(first_ns), ToSeconds(last_ns));
}

std::string RecordingLine(const std::string& dataset, const DataSource& source) {
  const std::vector<int64_t>& stamps_ns = source.stamps_ns();
  if (stamps_ns.size() < 2) return "recording  " + dataset;
  std::vector<double> steps_s;
  for (size_t i = 1; i < stamps_ns.size(); ++i) {
    steps_s.push_back(ToSeconds(stamps_ns[i] - stamps_ns[i - 1]));
  }
  return "recording  " + dataset +
         Format(": %zu frames, %.4g Hz, %.2f s (", stamps_ns.size(), 1 / Quantile(steps_s, 0.5),
                ToSeconds(stamps_ns.back() - stamps_ns.front())) +
         SpanText(stamps_ns.front(), stamps_ns.back()) + ")";
}

const char* LensText(const Camera& camera) {
  if (!camera.IsDistorted()) return "no distortion";
  return LensName(camera.lens);
}

std::string CameraLine(const RigCamera& mounted, const std::string& origin) {
  const Camera& c = mounted.camera;
  std::string out =
      Format("camera     %d x %d px, fx %.1f, fy %.1f, ", c.width, c.height, c.fx, c.fy) +
      LensText(c);
  if (mounted.line_time_s != 0) {
    out += Format(", rolling shutter of %.1f ms", 1e3 * mounted.line_time_s * c.height);
  }
  return out + ", from " + origin;
}

std::string MountLine(const RigCamera& mounted, MountedOn on, const std::string& origin) {
  const Eigen::Vector3d t = mounted.cam_from_body.translation();
  const char* key = on == MountedOn::kBody ? "cam_from_body" : "cam_from_world";
  return Format("mount      %s at (%.4g, %.4g, %.4g) m, turned %.1f deg, from ", key, t.x(), t.y(),
                t.z(), 57.29578 * Eigen::AngleAxisd(mounted.cam_from_body.rotation()).angle()) +
         origin;
}

// Of each camera of a rig what it is called and where its recording is, its camera and its mount.
std::vector<std::string> CameraLines(const Config& config) {
  std::vector<std::string> out;
  const std::vector<RigCamera>& cameras = config.set_up.rig.cameras;
  for (size_t i = 0; i < cameras.size(); ++i) {
    if (i < config.recordings.size()) {
      out.push_back("camera     " + cameras[i].name + ": recording " + config.recordings[i].path +
                    Format(", clock %+.6g s", cameras[i].clock_offset_s));
    }
    out.push_back(CameraLine(cameras[i], config.origins.camera));
    out.push_back(MountLine(cameras[i], config.set_up.rig.mounted_on, config.origins.mount));
  }
  return out;
}

std::string MapLine(const Config& config) {
  double smallest_m = 1e9, largest_m = 0;
  const TagMap all_tags = config.AllTags();
  for (const Tag& tag : all_tags.tags()) {
    smallest_m = std::min(smallest_m, tag.size_m);
    largest_m = std::max(largest_m, tag.size_m);
  }
  const std::string sizes = smallest_m == largest_m
                                ? Format("%.4g mm", 1e3 * smallest_m)
                                : Format("%.4g to %.4g mm", 1e3 * smallest_m, 1e3 * largest_m);
  return Format("map        %zu tags of ", all_tags.tags().size()) + config.set_up.map.family() +
         ", " + sizes + ", from " + config.origins.map +
         (config.origins.map_is_assumed ? " (neither --map nor --config names another)" : "");
}

std::string ImuLine(const ImuOptions& options, const std::vector<ImuSample>& samples) {
  if (samples.size() < 2) return "imu        none";
  const double span_s = ToSeconds(samples.back().t_ns - samples.front().t_ns);
  return Format("imu        %zu samples, %.4g Hz; noise %.2g rad/s and %.2g m/s^2 per root Hz%s",
                samples.size(), static_cast<double>(samples.size() - 1) / span_s,
                options.gyroscope_noise_density, options.accelerometer_noise_density,
                options.learn_noise ? ", or as learned" : "");
}

// What is given of the lens and the mount of the first camera.
std::string LensAndMountText(const Config& config) {
  const RigCamera& camera = config.set_up.rig.front();
  const auto focal = config.estimator.focal_sigma;
  std::string out = focal ? Format("focal length +- %.2g %%", 100 * *focal) : LensSigmaText(camera);
  if (out.empty()) out = "focal length and centre taken to be exact";
  if (camera.covariance.rows() <= 6 || camera.covariance.diagonal().tail(6).isZero(0)) {
    return out + ", mount taken to be exact";
  }
  const Eigen::VectorXd of_mount = camera.covariance.diagonal().tail(6).cwiseMax(0).cwiseSqrt();
  return out + Format(", mount +- %.2g mm, %.2g mrad", 1e3 * of_mount.tail(3).maxCoeff(),
                      1e3 * of_mount.head(3).maxCoeff());
}

// What is given of errors that last, and what is learned.
std::string ErrorsLine(const EstimateJob& job, const Config& config) {
  const EstimatorOptions& o = config.estimator;
  if (job.calibrate && o.systematic_errors) {
    return "errors     of lens and tags that last, in the covariance: as calibrated below";
  }
  if (!o.systematic_errors) return "errors     of lens, map and corners that last: not counted";
  const std::string rest = job.run.sliding_window ? "learned as frames come" : "learned";
  std::string out = "errors     that last, in the covariance: " + LensAndMountText(config);
  out +=
      ", lens' rest " +
      (o.lens_field_sigma_px ? Format("+- %.2g px", *o.lens_field_sigma_px) : rest) +
      ", tags' places " +
      (o.tag_sigma_m ? Format("+- %.2g mm", 1e3 * *o.tag_sigma_m) + " or more, as learned" : rest) +
      ", corners " +
      (o.corner_bias_sigma_px ? Format("+- %.2g px", *o.corner_bias_sigma_px) : rest);
  return out;
}

std::string TruthLine(const std::string& origin, const std::vector<TruthSample>& truth,
                      const std::vector<int64_t>& stamps_ns) {
  if (truth.empty()) return "truth      none";
  const auto within = [&](int64_t t_ns) {
    return t_ns >= truth.front().t_ns && t_ns <= truth.back().t_ns;
  };
  const auto covered = std::count_if(stamps_ns.begin(), stamps_ns.end(), within);
  return "truth      " + origin +
         Format(": %zu poses%s, %zd of %zu frames lie in its time", truth.size(),
                truth.front().twist ? " with twists" : "", covered, stamps_ns.size());
}

Status ReadTruth(const EstimateJob& job, const DataSource& source, Inputs* out,
                 std::string* origin) {
  if (job.ground_truth.empty()) {
    out->truth = source.ground_truth();
    *origin = source.truth_origin().empty() ? "the recording's own" : source.truth_origin();
    return Ok();
  }
  auto file = ReadTrajectoryFile(job.ground_truth, job.truth_topic, job.config.limits);
  if (!file) return file.error();
  out->truth = std::move(file->samples);
  out->warnings.insert(out->warnings.end(), file->notes.begin(), file->notes.end());
  *origin = job.ground_truth + " (" + file->form + ")";
  const std::vector<int64_t>& stamps_ns = source.stamps_ns();
  if (stamps_ns.empty()) return Ok();
  const bool apart =
      out->truth.back().t_ns < stamps_ns.front() || out->truth.front().t_ns > stamps_ns.back();
  if (!apart) return Ok();
  return Error{job.ground_truth + ": no sample lies within the recording: it has " +
               SpanText(out->truth.front().t_ns, out->truth.back().t_ns) + ", the recording " +
               SpanText(stamps_ns.front(), stamps_ns.back()) +
               ": bring both to one clock (a column of other stamps, or another unit)"};
}

}  // namespace

Result<Inputs> TakeInputs(const EstimateJob& job, const Config& config, const DataSource& source) {
  Inputs out;
  out.warnings = config.origins.notes;
  out.warnings.insert(out.warnings.end(), source.notes().begin(), source.notes().end());
  std::string origin;
  if (const Status read = ReadTruth(job, source, &out, &origin); !read) return read.error();
  out.lines = CameraLines(config);
  out.lines.insert(out.lines.begin(), RecordingLine(job.dataset, source));
  out.lines.push_back(MapLine(config));
  out.lines.push_back(ErrorsLine(job, config));
  out.lines.push_back(TruthLine(origin, out.truth, source.stamps_ns()));
  if (job.run.use_imu) out.lines.push_back(ImuLine(config.imu, source.imu()));
  return out;
}

std::vector<InputFile> InputFilesOf(const EstimateJob& job) {
  std::vector<InputFile> out;
  for (const auto& [flag, path] :
       {std::pair("--dataset", job.dataset), std::pair("--config", job.config.config),
        std::pair("--camera_file", job.config.camera_file), std::pair("--map", job.config.map.path),
        std::pair("--ground_truth", job.ground_truth)}) {
    if (path.empty() || IsCamera(path)) continue;
    const std::vector<InputFile> files = DigestInput(flag, path);
    out.insert(out.end(), files.begin(), files.end());
  }
  return out;
}

Result<std::vector<std::string>> CheckInputsAreKept(const EstimateJob& job, const Config& config) {
  RunFiles files;
  files.Reads("--config", job.config.config);
  files.Reads("--camera_file", job.config.camera_file);
  files.Reads("--map", job.config.map.path);
  files.Reads("--ground_truth", job.ground_truth);
  files.ReadsRecording("--dataset", job.dataset);
  if (auto checked = files.Writes("--overlay", job.overlay); !checked) return checked.error();
  if (auto checked = files.Writes("--profile", job.profile); !checked) return checked.error();
  const std::string stream = job.stream == "-" ? "" : job.stream;
  if (auto checked = files.Writes("--stream", stream); !checked) return checked.error();
  if (auto checked = files.Writes("--publish", job.publish.mcap); !checked) return checked.error();
  if (auto checked = files.WritesStandardOutput(); !checked) return checked.error();
  for (const std::string& file : FilesOfPieces(job.pieces)) files.Reads("--pieces", file);
  if (job.only_detections) return files.WritesSet("--output", PieceSet(job.output));
  ResultKinds kinds{job.run.sliding_window, job.write_covariance, job.calibrate,
                    job.map_unknown_tags, job.write_detections};
  if (!config.body.empty()) kinds.bodies.push_back(config.body);
  for (const TaggedBody& body : config.bodies) kinds.bodies.push_back(body.name);
  return files.WritesSet("--output", ResultSet(job.output, kinds));
}

std::string ConfigurationText(const Config& config) {
  return (config.recordings.empty() ? CameraSectionText(config) + MountSectionText(config)
                                    : CamerasSectionText(config)) +
         Format("\n# tag_map: %zu tags of ", config.AllTags().tags().size()) +
         config.set_up.map.family() + ", SHA-256 " + DigestText(MapSectionText(config)) + "\n" +
         OptionsText(config);
}

Status CheckMapIsGiven(const EstimateJob& job, const Config& config) {
  if (job.config.camera_file.empty() || !config.origins.map_is_assumed) return Ok();
  return Error{job.config.camera_file +
               ": a camera of your own needs a map: expected --map, or --config with a tag_map"};
}

}  // namespace tagtwist::internal
