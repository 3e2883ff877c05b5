#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cmath>
#include <filesystem>
#include <memory>
#include <optional>

#include "apps/python/frame_source.h"
#include "apps/python/trajectory_arrays.h"
#include "estimator/graph/noise_model.h"
#include "estimator/jobs/in_order.h"
#include "estimator/jobs/run.h"
#include "estimator/online/recording_options.h"

namespace tagtwist::internal::python {
namespace {

// tagtwist.Estimate.
struct EstimateArrays : StatesArrays {
  std::string mode;
  std::optional<StatesArrays> lagged;
  py::dict noise;
  Array reprojection_px;
  std::vector<std::string> warnings;
  std::optional<TrajectoryArrays> truth;
};

DetectionMode ToDetectionMode(const std::string& name, const RunOptions& run) {
  if (name == "auto") return DetectionMode::kAuto;
  if (name == "full") return DetectionMode::kFull;
  if (name != "guided") {
    throw Refusal("detection: expected \"auto\", \"full\" or \"guided\", got \"" + name + "\"");
  }
  if (!run.sliding_window) throw Refusal("detection: \"guided\" needs sliding_window");
  if (run.use_detections) throw Refusal("detection: \"guided\" needs images, not detections");
  return DetectionMode::kGuided;
}

py::dict ToNoise(const NoiseModel& noise) {
  const auto on = [](const MotionPrior& prior) {
    return prior.on == WhiteNoiseOn::kJerk ? "jerk" : "acceleration";
  };
  py::dict out;
  out["corner_sigma_px"] = noise.corner_sigma_px;
  out["track_sigma_px"] = noise.track_sigma_px;
  out["linear_white_noise_on"] = on(noise.linear);
  out["linear_psd"] = noise.linear.psd;
  out["angular_white_noise_on"] = on(noise.angular);
  out["angular_psd"] = noise.angular.psd;
  out["linear_shake_s"] = noise.linear.shake_s;
  out["angular_shake_s"] = noise.angular.shake_s;
  out["source"] = NameOf(noise.source);
  return out;
}

EstimateArrays ToArrays(const Estimate& estimate, const std::vector<TruthSample>& truth) {
  EstimateArrays out;
  static_cast<StatesArrays&>(out) = ToStates(estimate.frames);
  out.mode = ToString(estimate.mode);
  if (!estimate.lagged.empty()) out.lagged = ToStates(estimate.lagged);
  out.noise = ToNoise(estimate.noise);
  out.reprojection_px = FromMatrix(Eigen::Map<const Eigen::VectorXd>(
      estimate.reprojection_px.data(), static_cast<Eigen::Index>(estimate.reprojection_px.size())));
  out.warnings = estimate.warnings;
  if (!truth.empty()) out.truth = ToTrajectory(truth);
  return out;
}

bool IsPath(const py::object& object) {
  return py::isinstance<py::str>(object) || py::hasattr(object, "__fspath__");
}

// The recording at a path or the frames of an iterable; sets run.use_detections for the latter.
PythonSource OpenFrames(const py::object& frames, const Config& config, bool read_images,
                        RunOptions* run) {
  if (IsPath(frames)) {
    const std::string path = frames.cast<std::filesystem::path>().string();
    if (IsCamera(path)) throw Refusal(path + ": a camera is read frame by frame, SlidingWindow");
    const auto options = RecordingOptions(config, run->use_detections, read_images);
    return PythonSource(TakeOrRaise(OpenRecording(path, config, options)));
  }
  if (!py::isinstance<py::iterable>(frames)) {
    throw Refusal("frames: expected a path or an iterable of (t_ns, image), got " +
                  Describe(frames));
  }
  PythonSource source(frames.cast<py::iterable>());
  run->use_detections = source.has_detections();
  return source;
}

EstimateArrays RunIt(Config config, const py::object& frames, bool sliding_window,
                     bool use_detections, bool imu, bool tracks, const std::string& detection,
                     std::optional<int64_t> max_frames, std::optional<double> duration_s,
                     int threads) {
  RunOptions run;
  run.progress = false;
  run.sliding_window = sliding_window;
  run.use_detections = use_detections;
  run.use_imu = imu;
  if (max_frames && *max_frames < 1) throw Refusal("max_frames: expected >= 1");
  if (duration_s && !(*duration_s > 0 && *duration_s <= 1e9)) {
    throw Refusal("duration_s: expected > 0, at most 1e9");
  }
  if (threads < 0) throw Refusal("threads: expected >= 0, got " + std::to_string(threads));
  if (max_frames) run.max_frames = static_cast<size_t>(*max_frames);
  if (duration_s) run.duration_ns = std::llround(1e9 * *duration_s);
  run.threads = ResolveThreads(threads);
  if (!tracks) config.estimator.use_tracks = false;
  PythonSource source = OpenFrames(frames, config, tracks || !use_detections, &run);
  run.detection = ToDetectionMode(detection, run);
  const std::string name = IsPath(frames) ? std::string(py::str(frames)) : "frames";
  std::optional<Result<RunResult>> result;
  {
    const py::gil_scoped_release release;
    result = RunEstimate(name, &source, config, run);
  }
  source.RethrowFailure();
  return ToArrays(TakeOrRaise(std::move(*result)).estimate, source.ground_truth());
}

constexpr const char* kEstimateDoc = R"(Estimates a whole recording: tagtwist_estimate as a call.

frames          path of a recording (video, course .mat, EuRoC/ASL folder, folder of images),
                or an iterable of (t_ns, image) or of (t_ns, [Detection, ...]): stamps are
                integers in nanoseconds and grow, images as Detector.detect takes them
sliding_window  online, state by state, instead of one batch; the result has `lagged`
use_detections  corners come from the recording's own detections, not from its images
imu             the recording's IMU is in the estimate, too, as the configuration's section
                `imu` says
tracks          points followed through the images help where tags are few
detection       "auto", "full" (each image is searched) or "guided" (sliding_window)
max_frames, duration_s  where to end
threads         images measured at once, 0: as many as the machine has cores; the result
                does not depend on it

Bad input raises tagtwist.Error. Other Python threads run meanwhile.)";

}  // namespace

void BindEstimate(py::module_& module) {
  using E = EstimateArrays;
  py::class_<E, StatesArrays>(module, "Estimate", R"(The result of estimate(): States, and
  mode             "batch" or "sliding_window"
  lagged           States of the same frames at the window's lag, None in a batch
  noise            dict of the noise it was made with
  reprojection_px  (M,) distances of the corners from their predictions [px]
  warnings         list of str
  truth            Trajectory that came with the recording, or None)")
      .def_readonly("mode", &E::mode, "\"batch\" or \"sliding_window\"")
      .def_readonly("lagged", &E::lagged, "States at the window's lag, or None")
      .def_readonly("noise", &E::noise, "dict of the noise")
      .def_readonly("reprojection_px", &E::reprojection_px, "(M,) [px]")
      .def_readonly("warnings", &E::warnings, "list of str")
      .def_readonly("truth", &E::truth, "Trajectory that came with the recording, or None")
      .def("__repr__", [](const E& e) {
        return "<tagtwist.Estimate: " + e.mode + ", " + std::to_string(e.t_ns.size()) + " frames>";
      });
  module.def("estimate", &RunIt, kEstimateDoc, py::arg("config"), py::arg("frames"), py::kw_only(),
             py::arg("sliding_window") = false, py::arg("use_detections") = false,
             py::arg("imu") = false, py::arg("tracks") = true, py::arg("detection") = "auto",
             py::arg("max_frames") = py::none(), py::arg("duration_s") = py::none(),
             py::arg("threads") = 0);
}

}  // namespace tagtwist::internal::python
