#pragma once
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstdint>
#include <map>
#include <opencv2/core/mat.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"
#include "frontend/types/measurements.h"

/// The Python module `tagtwist`: values of the libraries as NumPy arrays, and back.
namespace tagtwist::internal::python {

namespace py = pybind11;
using Array = py::array_t<double, py::array::c_style>;
using IntArray = py::array_t<int64_t, py::array::c_style>;

/// tagtwist.Error in Python: bad input, told in one line.
struct Refusal : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The value, or its error raised as a Refusal.
template <typename T>
T TakeOrRaise(Result<T> result) {
  if (!result) throw Refusal(result.error().message);
  return std::move(*result);
}

/// What files may ask for at most, by name; None: the defaults.
using LimitValues = std::optional<std::map<std::string, double>>;
Limits ToLimits(const LimitValues& values);

/// What an object is, for messages: "an array of float64, shape (3, 4)", "str".
std::string Describe(const py::handle& object);

/// A stamp [ns]: a Python or NumPy integer; whatever else is refused.
int64_t ToStamp(const py::handle& object);
/// Stamps (N,), integers that grow strictly.
IntArray ToStamps(const py::handle& object);

/// Numbers of that shape, C order: "position: expected shape (5, 3), got (5, 4)". A copy.
Array ToArray(const py::handle& object, const std::string& name,
              const std::vector<py::ssize_t>& shape);

/// 8-bit gray image from a uint8 array (H, W), or (H, W, 3) in OpenCV's order B, G, R. A copy.
cv::Mat ToGrayImage(const py::handle& object);

/// A list of tagtwist.Detection.
std::vector<TagDetection> ToDetections(const py::handle& object);

/// A new array with the values of a matrix, row by row; a vector has one dimension.
template <typename Matrix>
Array FromMatrix(const Matrix& matrix) {
  std::vector<py::ssize_t> shape = {matrix.rows()};
  if (Matrix::ColsAtCompileTime != 1) shape.push_back(matrix.cols());
  Array out(shape);
  double* to = out.mutable_data();
  for (Eigen::Index i = 0; i < matrix.rows(); ++i) {
    for (Eigen::Index j = 0; j < matrix.cols(); ++j) *to++ = matrix(i, j);
  }
  return out;
}

// Each adds its part to the module.
void BindConfig(py::module_& module);
void BindDetector(py::module_& module);
void BindTrajectories(py::module_& module);
void BindEstimate(py::module_& module);
void BindRecording(py::module_& module);
void BindWindow(py::module_& module);
void BindLive(py::module_& module);
void BindCompare(py::module_& module);

}  // namespace tagtwist::internal::python
