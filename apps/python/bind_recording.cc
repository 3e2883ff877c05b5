#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <cstring>
#include <filesystem>
#include <memory>
#include <mutex>

#include "apps/python/trajectory_arrays.h"
#include "frontend/io/recordings/data_source.h"
#include "frontend/io/trajectories/trajectory_file.h"

namespace tagtwist::internal::python {
namespace {

// tagtwist.Recording: an iterator over a DataSource.
class Recording {
 public:
  Recording(const std::filesystem::path& path, bool use_detections, const LimitValues& limits)
      : source_(TakeOrRaise(OpenDataSource(
            path.string(), {use_detections, !use_detections, {}, {}, {}, ToLimits(limits)}))),
        use_detections_(use_detections) {}

  py::tuple Next() {
    const Frame frame = TakeOrRaise(NextFrame());
    if (use_detections_) return py::make_tuple(frame.t_ns, frame.detections);
    if (frame.image.empty()) return py::make_tuple(frame.t_ns, py::none());
    py::array_t<uint8_t> image({frame.image.rows, frame.image.cols});
    for (int row = 0; row < frame.image.rows; ++row) {
      std::memcpy(image.mutable_data(row), frame.image.ptr(row),
                  static_cast<size_t>(frame.image.cols));
    }
    return py::make_tuple(frame.t_ns, image);
  }

  std::optional<TrajectoryArrays> Truth() const {
    if (source_->ground_truth().empty()) return std::nullopt;
    return ToTrajectory(source_->ground_truth());
  }

 private:
  Result<Frame> NextFrame() {
    auto next = [this] {
      const py::gil_scoped_release release;
      const std::lock_guard<std::mutex> lock(mutex_);
      return source_->Next();
    }();
    if (!next) return next.error();
    if (!*next) throw py::stop_iteration();
    return std::move(**next);
  }

  std::mutex mutex_;  // of the source
  std::unique_ptr<DataSource> source_;
  bool use_detections_;
};

}  // namespace

void BindRecording(py::module_& module) {
  py::class_<Recording>(module, "Recording", R"(Frames of a recording, one after another.

Recording(path, use_detections=False, limits=None)

path            video, course .mat, EuRoC/ASL folder, folder of images
use_detections  the recording's own detections instead of its images
limits          {"frame_pixels": 4e8}: what its files may ask for at most; the keys of --limits

    for t_ns, image in tagtwist.Recording("flight.mp4"):

image is uint8 (H, W), or None where it cannot be decoded; with use_detections it is a list
of Detection.)")
      .def(py::init<const std::filesystem::path&, bool, const LimitValues&>(), py::arg("path"),
           py::kw_only(), py::arg("use_detections") = false, py::arg("limits") = py::none())
      .def("__iter__", [](Recording& self) -> Recording& { return self; })
      .def("__next__", &Recording::Next)
      .def_property_readonly("truth", &Recording::Truth,
                             "ground truth that came with it, a Trajectory or None");
  module.def(
      "read_truth",
      [](const std::filesystem::path& path, const LimitValues& limits) {
        return ToTrajectory(TakeOrRaise(ReadGroundTruth(path.string(), ToLimits(limits))));
      },
      py::arg("path"), py::kw_only(), py::arg("limits") = py::none(),
      "Trajectory from a file: CSV with columns t,x,y,z,qx,qy,qz,qw, TUM, EuRoC or course .mat.");
}

}  // namespace tagtwist::internal::python
