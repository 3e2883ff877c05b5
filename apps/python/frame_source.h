#pragma once
#include <exception>
#include <memory>
#include <optional>
#include <vector>

#include "apps/python/python_types.h"
#include "frontend/io/recordings/data_source.h"

namespace tagtwist::internal::python {

/// A source of frames that is read while Python's lock is released. Next() takes the lock for a
/// moment: for Ctrl-C, and, of an iterable, for the next item. What Python raises there ends the
/// recording, and RethrowFailure raises it again.
class PythonSource : public DataSource {
 public:
  /// A recording that was opened.
  explicit PythonSource(std::unique_ptr<DataSource> recording);
  /// An iterable of (t_ns, image or None) or (t_ns, [Detection, ...]), all of one kind.
  explicit PythonSource(const py::iterable& frames);

  /// Whether the frames of the iterable are detections.
  bool has_detections() const { return has_detections_; }
  /// Call when the lock is held again.
  void RethrowFailure() const;

  Result<std::optional<Frame>> Next() override;
  const std::vector<int64_t>& stamps_ns() const override;
  const std::vector<TruthSample>& ground_truth() const override;
  const std::vector<ImuSample>& imu() const override;

 private:
  std::optional<Frame> NextItem();
  Frame ToFrame(const py::handle& item);

  std::unique_ptr<DataSource> recording_;  // or
  py::iterator items_;
  std::optional<Frame> first_;  // read already, to know the kind
  bool has_detections_ = false;
  size_t n_items_ = 0;
  std::optional<int64_t> last_ns_;
  std::exception_ptr failure_;
};

}  // namespace tagtwist::internal::python
