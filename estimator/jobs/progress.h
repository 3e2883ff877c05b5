#pragma once
#include <chrono>
#include <cstddef>
#include <string>

namespace tagtwist::internal {

/// A progress bar on standard error; silent when that is not a terminal.
class Progress {
 public:
  /// `total` steps of the work called `label`; 0 when their number is not known.
  Progress(std::string label, size_t total);
  /// Wipes the line, so that what is printed next starts clean.
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;

  /// Tells that `done` steps are done; redraws at most ten times a second.
  void Update(size_t done);

 private:
  std::string label_;
  size_t total_ = 0;
  bool on_terminal_ = false;
  std::chrono::steady_clock::time_point start_, last_drawn_;
};

/// The bar's line, without the carriage return: "label [####......]  45%  12/40  3 s left".
std::string ProgressLine(const std::string& label, size_t done, size_t total, double elapsed_s);

}  // namespace tagtwist::internal
