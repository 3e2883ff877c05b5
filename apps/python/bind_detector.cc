#include <pybind11/stl.h>

#include <Eigen/Cholesky>
#include <memory>
#include <mutex>

#include "apps/python/python_types.h"
#include "estimator/online/config.h"
#include "estimator/online/image_size.h"
#include "frontend/front_end.h"
#include "frontend/tags/tag_finder.h"

namespace tagtwist::internal::python {
namespace {

using Corners = Eigen::Matrix<double, 4, 2, Eigen::RowMajor>;
using CornerCovariance = Eigen::Matrix<double, 8, 8, Eigen::RowMajor>;

TagDetection MakeDetection(int id, const py::object& corners, const py::object& covariance) {
  if (id < 0) throw Refusal("id: expected >= 0, got " + std::to_string(id));
  const Array pixels = ToArray(corners, "corners", {4, 2});
  const Eigen::Map<const Corners> rows(pixels.data());
  if (!rows.allFinite()) throw Refusal("corners: expected finite pixels");
  TagDetection out;
  out.id = id;
  for (Eigen::Index i = 0; i < 4; ++i) out.corners[static_cast<size_t>(i)] = rows.row(i);
  if (covariance.is_none()) return out;
  const Array entries = ToArray(covariance, "covariance", {8, 8});
  const Eigen::Matrix<double, 8, 8> matrix = Eigen::Map<const CornerCovariance>(entries.data());
  const bool is_symmetric = (matrix - matrix.transpose()).norm() <= 1e-9 * matrix.norm();
  if (!is_symmetric || matrix.llt().info() != Eigen::Success) {
    throw Refusal("covariance: expected a symmetric positive definite matrix [px^2]");
  }
  out.covariance = matrix;
  return out;
}

Array TagCornersOf(const TagDetection& tag) {
  Corners out;
  for (Eigen::Index i = 0; i < 4; ++i) out.row(i) = tag.corners[static_cast<size_t>(i)];
  return FromMatrix(out);
}

py::object CovarianceOf(const TagDetection& tag) {
  if (!tag.covariance) return py::none();
  return FromMatrix(*tag.covariance);
}

// Finds the usable tags of single images.
class Detector {
 public:
  explicit Detector(const Config& config)
      : config_(config),
        finder_(TakeOrRaise(TagFinder::Create(config.set_up, config.front_end.detector))) {}

  std::vector<TagDetection> Detect(const py::object& image) {
    const cv::Mat gray = ToGrayImage(image);
    if (const auto problem = ImageSizeProblem(gray, config_.set_up.rig.front().camera))
      throw Refusal(*problem);
    const py::gil_scoped_release release;
    const std::lock_guard<std::mutex> lock(mutex_);  // one image at a time
    return finder_.Find(gray);
  }

 private:
  Config config_;
  TagFinder finder_;
  std::mutex mutex_;
};

}  // namespace

void BindDetector(py::module_& module) {
  py::class_<TagDetection>(module, "Detection",
                           R"(A tag seen in an image.

Detection(id, corners, covariance=None)

id          the tag's number
corners     (4, 2) u v [px]: bottom-left, bottom-right, top-right, top-left of the tag as
            printed; the centre of the image's top-left pixel is (0, 0)
covariance  (8, 8) of u1 v1 .. u4 v4 [px^2], or None where it is not known)")
      .def(py::init(&MakeDetection), py::arg("id"), py::arg("corners"),
           py::arg("covariance") = py::none())
      .def_readonly("id", &TagDetection::id, "the tag's number")
      .def_property_readonly("corners", &TagCornersOf, "(4, 2) [px]")
      .def_property_readonly("covariance", &CovarianceOf, "(8, 8) [px^2], or None")
      .def("__repr__", [](const TagDetection& tag) {
        return "<tagtwist.Detection: tag " + std::to_string(tag.id) + ">";
      });
  py::class_<Detector>(module, "Detector", R"(Finds the tags of the map in single images.

Detector(config)

Threads may share one; it does one image at a time.)")
      .def(py::init<const Config&>(), py::arg("config"))
      .def("detect", &Detector::Detect, py::arg("image"),
           R"(The usable tags of an image, a list of Detection sorted by id.

image: uint8, (H, W) gray or (H, W, 3) in OpenCV's order B, G, R, of the camera's size.
Usable: in the map, once in the image, clear of its border. Corners are refined on the
whole pattern, unless the option detector.refine_pattern says not.)");
}

}  // namespace tagtwist::internal::python
