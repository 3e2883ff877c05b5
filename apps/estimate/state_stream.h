#pragma once
#include <cstddef>
#include <memory>
#include <string>

#include "estimator/result/estimate.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Rows of states.csv as they come, the header first: to a file, a FIFO, or standard output. With
/// several bodies each has a frame's row, and the last column is its name. Each row is one write,
/// so that a reader has it at once. When the reader goes away the stream ends, and nothing else
/// does: no SIGPIPE comes of it, whatever the process does with that signal.
class StateStream {
 public:
  /// `path`: a file, which is emptied; a FIFO, whose reader is waited for; "-": standard output.
  /// "rows.csv: cannot write: Permission denied".
  static Result<std::unique_ptr<StateStream>> Open(const std::string& path,
                                                   bool names_bodies = false);
  ~StateStream();
  StateStream(const StateStream&) = delete;
  StateStream& operator=(const StateStream&) = delete;

  /// The next row; waits while a pipe is full. After a failure nothing is written any more.
  void Write(const FrameEstimate& frame, const std::string& body = "");
  /// Why rows are missing at the end, one line; empty while all were written.
  const std::string& problem() const { return problem_; }
  /// True where it was not the reader that went away: rows that were asked for are lost.
  bool failed() const { return failed_; }

 private:
  StateStream(std::string path, int descriptor, bool names_bodies);
  void WriteRow(std::string line, const std::string& body);
  void WriteText(const std::string& text);

  std::string path_;
  int descriptor_;
  bool names_bodies_;
  size_t rows_ = 0;
  std::string problem_;
  bool failed_ = false;
};

}  // namespace tagtwist::internal
