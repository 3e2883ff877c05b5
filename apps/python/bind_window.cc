#include <pybind11/stl.h>

#include <mutex>
#include <optional>

#include "apps/python/trajectory_arrays.h"
#include "estimator/online/online_estimator.h"

namespace tagtwist::internal::python {
namespace {

// tagtwist.SlidingWindow: an OnlineEstimator that keeps the lagged states until they are fetched.
class Window {
  template <typename Function>
  auto Locked(const Function& function) {
    const py::gil_scoped_release release;
    const std::lock_guard<std::mutex> lock(mutex_);
    return function();
  }

 public:
  explicit Window(const Config& config)
      : estimator_(TakeOrRaise(OnlineEstimator::Create(config))) {}

  std::optional<StateArrays> Add(const py::object& stamp, const py::object& frame) {
    const int64_t t_ns = ToStamp(stamp);
    const bool is_image = py::isinstance<py::array>(frame);
    const cv::Mat gray = is_image ? ToGrayImage(frame) : cv::Mat();
    const bool is_blank = is_image || frame.is_none();
    const std::vector<TagDetection> tags =
        is_blank ? std::vector<TagDetection>() : ToDetections(frame);
    std::optional<Result<WindowOutput>> output;
    {
      const py::gil_scoped_release release;
      const std::lock_guard<std::mutex> lock(mutex_);
      output = AddLocked(t_ns, gray, tags, is_image);
    }
    const WindowOutput taken = TakeOrRaise(std::move(*output));
    if (taken.current.status == FrameStatus::kNoFix) return std::nullopt;
    return ToState(taken.current);
  }

  StatesArrays TakeLagged() {
    const std::vector<FrameEstimate> frames = Locked([this] { return std::exchange(lagged_, {}); });
    return ToStates(frames);
  }

  StatesArrays Finish() {
    const std::vector<FrameEstimate> frames = Locked([this] {
      if (!finished_) Keep(estimator_.Finish());
      finished_ = true;
      return std::exchange(lagged_, {});
    });
    return ToStates(frames);
  }

  std::vector<std::string> Warnings() {
    return Locked([this] { return estimator_.window().Warnings(); });
  }

 private:
  Result<WindowOutput> AddLocked(int64_t t_ns, const cv::Mat& gray,
                                 const std::vector<TagDetection>& tags, bool is_image) {
    if (finished_) return Error{"the window is finished: no frame may follow"};
    auto output = is_image ? estimator_.AddImage(t_ns, gray) : estimator_.AddTags(t_ns, tags);
    if (output) Keep(std::move(output->lagged));
    return output;
  }

  void Keep(std::vector<FrameEstimate> frames) {
    for (FrameEstimate& frame : frames) lagged_.push_back(std::move(frame));
  }

  std::mutex mutex_;  // of all that follows
  OnlineEstimator estimator_;
  std::vector<FrameEstimate> lagged_;  // not fetched yet
  bool finished_ = false;
};

}  // namespace

void BindWindow(py::module_& module) {
  py::class_<Window>(module, "SlidingWindow", R"(Online: frames one by one, a state for each.

SlidingWindow(config)

The states are those of estimate(..., sliding_window=True) over the same frames.)")
      .def(py::init<const Config&>(), py::arg("config"))
      .def("add", &Window::Add, py::arg("t_ns"), py::arg("frame"),
           R"(State of the next frame, from all that came until now.

t_ns   integer stamp [ns]; stamps grow
frame  image as Detector.detect takes it, a list of Detection, or None: nothing was seen
None is returned while there is no state: before the first tag, or while two attitudes
are open.)")
      .def("take_lagged", &Window::TakeLagged,
           "States of the frames that left the window, smoothed, since the last call.")
      .def("finish", &Window::Finish,
           "States of all frames that take_lagged() has not given, the last ones included. No "
           "frame may follow.")
      .def_property_readonly("warnings", &Window::Warnings,
                             "what the frames say of tags and map, list of str");
}

}  // namespace tagtwist::internal::python
