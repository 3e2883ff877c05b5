#include "apps/python/frame_source.h"

#include <utility>

namespace tagtwist::internal::python {

PythonSource::PythonSource(std::unique_ptr<DataSource> recording)
    : recording_(std::move(recording)) {}

PythonSource::PythonSource(const py::iterable& frames) : items_(py::iter(frames)) {
  first_ = NextItem();
}

void PythonSource::RethrowFailure() const {
  if (failure_) std::rethrow_exception(failure_);
}

Frame PythonSource::ToFrame(const py::handle& item) {
  Frame out;
  out.name = "frame " + std::to_string(n_items_);
  if (!py::isinstance<py::sequence>(item) || py::len(item) != 2) {
    throw Refusal(out.name + ": expected (t_ns, image) or (t_ns, detections), got " +
                  Describe(item));
  }
  const auto pair = py::reinterpret_borrow<py::sequence>(item);
  const py::object content = pair[1];
  const bool is_image = content.is_none() || py::isinstance<py::array>(content);
  try {
    out.t_ns = ToStamp(py::object(pair[0]));
    if (last_ns_ && out.t_ns <= *last_ns_) {
      throw Refusal("stamps must grow: " + std::to_string(out.t_ns) + " ns follows " +
                    std::to_string(*last_ns_) + " ns");
    }
    if (n_items_ == 0) has_detections_ = !is_image;
    if (is_image == has_detections_) {
      throw Refusal(std::string("expected ") + (has_detections_ ? "detections" : "an image") +
                    " as in the frames before, got " + Describe(content));
    }
    if (!is_image) out.detections = ToDetections(content);
    if (is_image && !content.is_none()) out.image = ToGrayImage(content);
  } catch (const Refusal& refusal) {
    throw Refusal(out.name + ": " + refusal.what());
  }
  return out;
}

std::optional<Frame> PythonSource::NextItem() {
  if (items_ == py::iterator::sentinel()) return std::nullopt;
  Frame frame = ToFrame(*items_);
  ++n_items_;
  last_ns_ = frame.t_ns;
  return frame;
}

Result<std::optional<Frame>> PythonSource::Next() {
  if (first_) return std::exchange(first_, std::nullopt);
  const py::gil_scoped_acquire lock;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (!recording_) {
      ++items_;
      return NextItem();
    }
  } catch (...) {
    failure_ = std::current_exception();
    return Error{"stopped"};
  }
  const py::gil_scoped_release release;
  return recording_->Next();
}

const std::vector<int64_t>& PythonSource::stamps_ns() const {
  static const std::vector<int64_t> none;
  return recording_ ? recording_->stamps_ns() : none;
}

const std::vector<TruthSample>& PythonSource::ground_truth() const {
  static const std::vector<TruthSample> none;
  return recording_ ? recording_->ground_truth() : none;
}

const std::vector<ImuSample>& PythonSource::imu() const {
  static const std::vector<ImuSample> none;
  return recording_ ? recording_->imu() : none;
}

}  // namespace tagtwist::internal::python
