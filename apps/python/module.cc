#include <glog/logging.h>

#include <cstdlib>
#include <opencv2/core/utils/logger.hpp>

#include "apps/python/python_types.h"

namespace {

constexpr const char* kModuleDoc = R"(Motion capture from a printed sheet of AprilTags.

    import tagtwist
    config = tagtwist.load_config("course.yaml")       # camera, mount, tag map, options
    result = tagtwist.estimate(config, "flight.mp4")   # or an iterable of (t_ns, image)
    result.position        # (N, 3) of the body in the map's world [m]
    result.covariance      # (N, 12, 12)
    tagtwist.compare(result, "truth.tum")["optimised"]["position_rmse_m"]

Online, frame by frame:

    window = tagtwist.SlidingWindow(config)
    for t_ns, image in tagtwist.Recording("flight.mp4"):   # or your camera
        state = window.add(t_ns, image)                # None while there is none

Single images: tagtwist.Detector(config).detect(image).

Stamps are integers in nanoseconds. World W: that of the tag map; body B. Quaternions are
x y z w, world from body. Velocities of the body's origin in W [m/s], rates in B [rad/s].
Images are uint8 arrays, (H, W) gray or (H, W, 3) in the order B, G, R.
Bad input raises tagtwist.Error, a ValueError, with one line.)";

}  // namespace

PYBIND11_MODULE(tagtwist, module) {
  namespace python = tagtwist::internal::python;
  // Faults are told in one line, by exceptions.
  FLAGS_minloglevel = google::GLOG_FATAL;
  cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
  ::setenv("OPENCV_FFMPEG_LOGLEVEL", "-8", 0);

  module.doc() = kModuleDoc;
  module.attr("__version__") = TAGTWIST_VERSION;
  pybind11::register_exception<python::Refusal>(module, "Error", PyExc_ValueError).doc() =
      "Bad input: a file, an option or an array; the text says which and why, in one line.";
  python::BindConfig(module);
  python::BindDetector(module);
  python::BindTrajectories(module);
  python::BindEstimate(module);
  python::BindRecording(module);
  python::BindWindow(module);
  python::BindLive(module);
  python::BindCompare(module);
}
