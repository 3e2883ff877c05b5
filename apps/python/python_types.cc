#include "apps/python/python_types.h"

#include <cstring>
#include <opencv2/imgproc.hpp>

#include "frontend/base/set_limit.h"

namespace tagtwist::internal::python {
namespace {

std::string ShapeText(const std::vector<py::ssize_t>& shape) {
  std::string out = "(";
  for (size_t i = 0; i < shape.size(); ++i) {
    out += (i > 0 ? ", " : "") + std::to_string(shape[i]);
  }
  return out + (shape.size() == 1 ? ",)" : ")");
}

std::vector<py::ssize_t> ShapeOf(const py::array& array) {
  return {array.shape(), array.shape() + array.ndim()};
}

}  // namespace

Limits ToLimits(const LimitValues& values) {
  Limits out;
  if (!values) return out;
  for (const auto& [name, value] : *values) {
    if (const Status set = SetLimit(name, value, &out); !set) {
      throw Refusal("limits: " + set.error().message);
    }
  }
  if (const auto problem = out.Problem()) throw Refusal("limits: " + *problem);
  return out;
}

std::string Describe(const py::handle& object) {
  if (!py::isinstance<py::array>(object)) {
    return py::str(py::type::handle_of(object).attr("__name__"));
  }
  const auto array = py::reinterpret_borrow<py::array>(object);
  return "an array of " + std::string(py::str(array.dtype())) + ", shape " +
         ShapeText(ShapeOf(array));
}

int64_t ToStamp(const py::handle& object) {
  const bool is_integer = PyIndex_Check(object.ptr()) != 0 && !PyBool_Check(object.ptr());
  try {
    if (is_integer) return py::cast<int64_t>(py::int_(py::reinterpret_borrow<py::object>(object)));
  } catch (const py::error_already_set&) {
    // Too large, or an array of several: refused below.
  } catch (const py::cast_error&) {
  }
  throw Refusal("stamp: expected an integer, nanoseconds, got " + Describe(object));
}

IntArray ToStamps(const py::handle& object) {
  const py::array any = py::array::ensure(object);
  const bool is_integer = any && (any.dtype().kind() == 'i' || any.dtype().kind() == 'u');
  if (!is_integer || any.ndim() != 1) {
    PyErr_Clear();
    throw Refusal("t_ns: expected integers, nanoseconds, shape (N,), got " + Describe(object));
  }
  const IntArray stamps = IntArray::ensure(any);
  IntArray out(stamps.size());
  std::memcpy(out.mutable_data(), stamps.data(), sizeof(int64_t) * stamps.size());
  for (py::ssize_t i = 1; i < out.size(); ++i) {
    if (!(out.at(i) > out.at(i - 1))) {
      throw Refusal("t_ns: expected stamps that grow, but [" + std::to_string(i) + "] does not");
    }
  }
  return out;
}

Array ToArray(const py::handle& object, const std::string& name,
              const std::vector<py::ssize_t>& shape) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw Refusal(name + ": expected numbers, shape " + ShapeText(shape) + ", got " +
                  Describe(object));
  }
  if (ShapeOf(array) != shape) {
    throw Refusal(name + ": expected shape " + ShapeText(shape) + ", got " +
                  ShapeText(ShapeOf(array)));
  }
  Array out(shape);
  std::memcpy(out.mutable_data(), array.data(), sizeof(double) * array.size());
  return out;
}

cv::Mat ToGrayImage(const py::handle& object) {
  using Bytes = py::array_t<uint8_t, py::array::c_style>;
  const bool is_bytes = py::isinstance<py::array_t<uint8_t>>(object);
  const auto array = is_bytes ? Bytes::ensure(object) : Bytes();
  const bool is_gray = is_bytes && array.ndim() == 2;
  const bool is_colour = is_bytes && array.ndim() == 3 && array.shape(2) == 3;
  if (!is_gray && !is_colour) {
    throw Refusal("image: expected a uint8 array of shape (H, W) or (H, W, 3), got " +
                  Describe(object));
  }
  if (array.size() == 0) throw Refusal("image: expected pixels, got none");
  // OpenCV does not write through the views.
  const cv::Mat view(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)),
                     is_gray ? CV_8UC1 : CV_8UC3, const_cast<uint8_t*>(array.data()));
  if (is_gray) return view.clone();
  cv::Mat gray;
  cv::cvtColor(view, gray, cv::COLOR_BGR2GRAY);
  return gray;
}

std::vector<TagDetection> ToDetections(const py::handle& object) {
  if (!py::isinstance<py::sequence>(object) || py::isinstance<py::str>(object)) {
    throw Refusal("frame: expected an image or a list of tagtwist.Detection, got " +
                  Describe(object));
  }
  std::vector<TagDetection> out;
  for (const py::handle& item : object) {
    if (!py::isinstance<TagDetection>(item)) {
      throw Refusal("detections: expected tagtwist.Detection, got " + Describe(item));
    }
    out.push_back(item.cast<TagDetection>());
  }
  return out;
}

}  // namespace tagtwist::internal::python
