#pragma once
#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "estimator/result/estimate.h"
#include "frontend/base/files/file_set.h"
#include "frontend/base/result.h"
#include "frontend/types/measurements.h"

namespace tagtwist::internal {

/// Which rows are asked for.
struct RowsAsked {
  bool covariance = false, detections = false;
  /// Names of the bodies, where there are several; else one without a name.
  std::vector<std::string> bodies = {""};
};

/// The files of a run's results that have a row a frame (WriteResults), written while it goes on:
/// into a set that takes its place when the others have been added to it. Goes without a trace
/// where that does not come to pass. What cannot be written is told once, and again by each call
/// that follows.
class ResultRows {
 public:
  static Result<std::unique_ptr<ResultRows>> Begin(const std::string& folder,
                                                   const RowsAsked& asked);

  /// The tags of a frame.
  Status AddMeasured(const FrameMeasurements& frame);
  /// A body's state at a frame, and that of the same at the window's lag; each in order.
  Status Add(size_t body, const FrameEstimate& frame);
  Status AddLagged(size_t body, const FrameEstimate& frame);
  Status status() const { return status_; }
  FileSet& set() { return *set_; }

 private:
  ResultRows(std::unique_ptr<FileSet> set, RowsAsked asked);
  void Write(const std::string& name, const std::string& text);
  void WriteHeaders(const std::string& suffix, bool lagged);
  void WriteRows(const std::string& suffix, bool lagged, const FrameEstimate& frame);

  std::unique_ptr<FileSet> set_;
  RowsAsked asked_;
  std::vector<bool> has_lagged_;  // of each body
  Status status_ = Ok();
};

/// All states of an estimate, and of other bodies'.
Status AddStates(const Estimate& estimate, const std::vector<BodyEstimate>& of_others,
                 ResultRows* rows);

}  // namespace tagtwist::internal
