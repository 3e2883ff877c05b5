#include <pybind11/stl.h>

#include <atomic>
#include <cstring>
#include <deque>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "apps/python/trajectory_arrays.h"
#include "estimator/jobs/online_run.h"
#include "estimator/live/live_feed.h"
#include "estimator/online/recording_options.h"

namespace tagtwist::internal::python {
namespace {

Result<std::unique_ptr<DataSource>> OpenPlace(const std::string& place, const Config& config) {
  if (!IsCamera(place)) {
    return OpenRecording(place, config, RecordingOptions(config, /*use_detections=*/false, true));
  }
  if (!config.recordings.empty()) {
    return Error{place +
                 ": is one camera, and the configuration has a section cameras: name it by " +
                 "camera and cam_from_body instead"};
  }
  return OpenCameraSource(place, config.set_up.rig.front().camera, SteadyNowNs, config.limits);
}

py::object ImageArray(const cv::Mat& image) {
  if (image.empty()) return py::none();
  py::array_t<uint8_t> out({image.rows, image.cols});
  for (int row = 0; row < image.rows; ++row) {
    std::memcpy(out.mutable_data(row), image.ptr(row), static_cast<size_t>(image.cols));
  }
  return std::move(out);
}

// Without a state NaN, in whatever the estimator left there.
FrameEstimate WithNan(FrameEstimate state) {
  if (state.status != FrameStatus::kNoFix) return state;
  constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
  state.state.world_from_body.params.setConstant(kNan);
  state.state.twist.v_world.setConstant(kNan);
  state.state.twist.omega_body.setConstant(kNan);
  state.covariance.setConstant(kNan);
  return state;
}

// tagtwist.Live: states as their frames come. Memory does not grow with the frames.
class Live {
 public:
  Live(const std::string& place, const Config& config)
      : rig_(config.set_up.rig), body_names_(BodyNames(config)) {
    LiveFeed::Options options;
    options.paced = !IsCamera(place);
    options.stop = [this] { return is_closed_ || IsInterrupted(); };
    feed_ = std::make_unique<LiveFeed>(TakeOrRaise(OpenPlace(place, config)), options);
    RunOptions run;
    run.sliding_window = true;
    run.most_kept = 1;
    run.progress = false;
    run.age_ms = [this](int64_t t_ns) { return feed_->AgeMs(t_ns); };
    run_.emplace(TakeOrRaise(OnlineRun::Create(place, feed_.get(), config, run)));
  }

  StateArrays Next() {
    std::optional<Result<bool>> found;
    SeenState next;
    {
      const py::gil_scoped_release release;
      const std::lock_guard<std::mutex> lock(mutex_);
      found = FillLocked();
      if (*found && **found) next = TakeLocked();
    }
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    if (!TakeOrRaise(std::move(*found))) throw py::stop_iteration();
    return ToState(next.state, next.body);
  }

  void Run(const py::function& callback) {
    while (true) {
      try {
        const py::object go_on = callback(Next());
        if (go_on.is(py::bool_(false))) return Close();
      } catch (const py::stop_iteration&) {
        return;
      }
    }
  }

  void Close() { is_closed_ = true; }
  size_t FramesDropped() const { return feed_->dropped(); }
  double LatencyMs() const { return latency_ms_; }
  py::object Image() const {
    for (const CameraImage& image : LastImages()) {
      if (image.camera == 0) return ImageArray(image.image);
    }
    return py::none();
  }
  py::dict Images() const {
    py::dict out;
    for (const CameraImage& image : LastImages()) {
      if (image.image.empty()) continue;
      out[py::str(rig_.cameras.at(static_cast<size_t>(image.camera)).name)] =
          ImageArray(image.image);
    }
    return out;
  }

 private:
  struct SeenState {
    std::string body;
    FrameEstimate state;
  };

  // Ctrl-C, asked for while a frame is waited for, without Python's lock.
  bool IsInterrupted() {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() == 0) return false;
    failure_ = std::make_exception_ptr(py::error_already_set());
    return true;
  }

  // Whether there is a state to be had: of the last frame, or of the next one.
  Result<bool> FillLocked() {
    if (is_closed_) return false;
    if (!waiting_.empty()) return true;
    const auto state = run_->Next();
    if (!state) return state.error();
    if (*state == nullptr) return false;
    const OnlineFrame& frame = run_->frame();
    for (size_t i = 0; i < frame.bodies.size(); ++i) {
      waiting_.push_back({body_names_[i], WithNan(frame.bodies[i].state)});
    }
    images_ = frame.images;
    latency_ms_ = frame.age_ms;
    return true;
  }
  SeenState TakeLocked() {
    SeenState out = std::move(waiting_.front());
    waiting_.pop_front();
    return out;
  }
  std::vector<CameraImage> LastImages() const {
    const py::gil_scoped_release release;
    const std::lock_guard<std::mutex> lock(mutex_);
    return images_;
  }

  mutable std::mutex mutex_;  // of the run, of what waits and of the images
  Rig rig_;
  std::vector<std::string> body_names_;
  std::deque<SeenState> waiting_;  // of one frame
  std::vector<CameraImage> images_;
  std::atomic<double> latency_ms_{0};
  std::atomic<bool> is_closed_{false};
  std::exception_ptr failure_;
  std::unique_ptr<LiveFeed> feed_;
  std::optional<OnlineRun> run_;  // of the feed
};

constexpr const char* kLiveDoc =
    R"(States as their frames come, from a camera or a recording played at its own speed.

live(place, config, callback=None)

place     "camera:0", "camera:/dev/video0", "camera:URL", or a recording's path
callback  called with each State until the end, or until it returns False; nothing is
          returned then. Without it, an iterator of states:

    for state in tagtwist.live("camera:0", config):
        print(state.status, state.position, state.covariance.diagonal() ** 0.5)

Of several bodies each has a State a frame; State.body is its name. A frame that comes while
others wait may be dropped: the newest win. A frame without a state has status "no_fix" and
NaN. Other Python threads run meanwhile; Ctrl-C ends it.)";

}  // namespace

void BindLive(py::module_& module) {
  py::class_<Live>(module, "Live", "What live() gives: an iterator of State.")
      .def("__iter__", [](Live& self) -> Live& { return self; })
      .def("__next__", &Live::Next)
      .def("close", &Live::Close, "Ends it: the next state is not waited for.")
      .def("__enter__", [](Live& self) -> Live& { return self; })
      .def("__exit__", [](Live& self, const py::args&) { self.Close(); })
      .def_property_readonly(
          "image", &Live::Image,
          "uint8 (H, W), a copy of the last frame's image by the first camera, or None")
      .def_property_readonly("images", &Live::Images,
                             "of the last frame, by the camera's name: uint8 (H, W), copies")
      .def_property_readonly("frames_dropped", &Live::FramesDropped,
                             "frames that came while others waited, so far")
      .def_property_readonly("latency_ms", &Live::LatencyMs,
                             "from the last frame's stamp to its state");
  module.def(
      "live",
      [](const py::object& place, const Config& config, const py::object& callback) -> py::object {
        auto live = std::make_unique<Live>(std::string(py::str(place)), config);
        if (callback.is_none()) return py::cast(std::move(live));
        live->Run(callback.cast<py::function>());
        return py::none();
      },
      py::arg("place"), py::arg("config"), py::arg("callback") = py::none(), kLiveDoc);
}

}  // namespace tagtwist::internal::python
