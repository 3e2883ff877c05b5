#include <pybind11/stl.h>

#include <atomic>
#include <cstring>
#include <exception>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>

#include "apps/python/trajectory_arrays.h"
#include "estimator/jobs/measurement_stream.h"
#include "estimator/live/live_feed.h"
#include "estimator/online/online_estimator.h"
#include "estimator/online/recording_options.h"

namespace tagtwist::internal::python {
namespace {

Result<std::unique_ptr<DataSource>> OpenPlace(const std::string& place, const Config& config) {
  return IsCamera(place)
             ? OpenCameraSource(place, config.set_up.rig.front().camera, SteadyNowNs, config.limits)
             : OpenRecording(place, config,
                             RecordingOptions(config, /*use_detections=*/false, true));
}

// tagtwist.Live: states as their frames come. Memory does not grow with the frames.
class Live {
 public:
  Live(const std::string& place, const Config& config)
      : rig_(config.set_up.rig), estimator_(TakeOrRaise(OnlineEstimator::Create(config))) {
    LiveFeed::Options options;
    options.paced = !IsCamera(place);
    options.stop = [this] { return is_closed_ || IsInterrupted(); };
    feed_ = std::make_unique<LiveFeed>(TakeOrRaise(OpenPlace(place, config)), options);
  }

  StateArrays Next() {
    std::optional<Result<std::optional<FrameEstimate>>> next;
    {
      const py::gil_scoped_release release;
      const std::lock_guard<std::mutex> lock(mutex_);
      next = NextLocked();
    }
    if (failure_) std::rethrow_exception(std::exchange(failure_, nullptr));
    const auto state = TakeOrRaise(std::move(*next));
    if (!state) throw py::stop_iteration();
    return ToState(*state);
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
    const py::gil_scoped_release release;
    const std::lock_guard<std::mutex> lock(mutex_);
    const py::gil_scoped_acquire acquire;
    if (image_.empty()) return py::none();
    py::array_t<uint8_t> out({image_.rows, image_.cols});
    for (int row = 0; row < image_.rows; ++row) {
      std::memcpy(out.mutable_data(row), image_.ptr(row), static_cast<size_t>(image_.cols));
    }
    return out;
  }

 private:
  // Ctrl-C, asked for while a frame is waited for, without Python's lock.
  bool IsInterrupted() {
    const py::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() == 0) return false;
    failure_ = std::make_exception_ptr(py::error_already_set());
    return true;
  }

  Result<std::optional<FrameEstimate>> NextLocked() {
    const auto frame = NextFrame(feed_.get(), rig_);
    if (!frame) return frame.error();
    if (!*frame) return std::optional<FrameEstimate>();
    auto output = estimator_.AddImage((*frame)->t_ns, (*frame)->image);
    if (!output) return output.error();
    image_ = (*frame)->image;
    latency_ms_ = feed_->AgeMs((*frame)->t_ns);
    FrameEstimate& state = output->current;
    if (state.status == FrameStatus::kNoFix) {
      constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
      state.state.world_from_body.params.setConstant(kNan);
      state.state.twist.v_world.setConstant(kNan);
      state.state.twist.omega_body.setConstant(kNan);
      state.covariance.setConstant(kNan);
    }
    return std::optional<FrameEstimate>(std::move(state));
  }

  mutable std::mutex mutex_;  // of the estimator and the image
  Rig rig_;
  OnlineEstimator estimator_;
  cv::Mat image_;
  std::atomic<double> latency_ms_{0};
  std::atomic<bool> is_closed_{false};
  std::exception_ptr failure_;
  std::unique_ptr<LiveFeed> feed_;
};

constexpr const char* kLiveDoc =
    R"(States as their frames come, from a camera or a recording played at its own speed.

live(place, config, callback=None)

place     "camera:0", "camera:/dev/video0", "camera:URL", or a recording's path
callback  called with each State until the end, or until it returns False; nothing is
          returned then. Without it, an iterator of states:

    for state in tagtwist.live("camera:0", config):
        print(state.status, state.position, state.covariance.diagonal() ** 0.5)

A frame that comes while others wait may be dropped: the newest win. A frame without a state
has status "no_fix" and NaN. Other Python threads run meanwhile; Ctrl-C ends it.)";

}  // namespace

void BindLive(py::module_& module) {
  py::class_<Live>(module, "Live", "What live() gives: an iterator of State.")
      .def("__iter__", [](Live& self) -> Live& { return self; })
      .def("__next__", &Live::Next)
      .def("close", &Live::Close, "Ends it: the next state is not waited for.")
      .def("__enter__", [](Live& self) -> Live& { return self; })
      .def("__exit__", [](Live& self, const py::args&) { self.Close(); })
      .def_property_readonly("image", &Live::Image,
                             "uint8 (H, W), a copy of the last state's image, or None")
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
