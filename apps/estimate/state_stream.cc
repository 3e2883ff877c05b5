#include "apps/estimate/state_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string_view>
#include <system_error>
#include <utility>

#include "estimator/report/files/states_csv.h"

namespace tagtwist {

Result<std::unique_ptr<StateStream>> StateStream::Open(const std::string& path) {
  const bool to_stdout = path == "-";
  const int descriptor = to_stdout
                             ? STDOUT_FILENO
                             : ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0)
    return Error{path + ": cannot write: " + std::generic_category().message(errno)};
  std::signal(SIGPIPE, SIG_IGN);
  std::unique_ptr<StateStream> out(
      new StateStream(to_stdout ? "standard output" : path, descriptor));
  out->WriteText(StatesCsvHeader());
  return out;
}

StateStream::StateStream(std::string path, int descriptor)
    : path_(std::move(path)), descriptor_(descriptor) {}

StateStream::~StateStream() {
  if (descriptor_ != STDOUT_FILENO) ::close(descriptor_);
}

void StateStream::Write(const FrameEstimate& frame) {
  if (!problem_.empty()) return;
  WriteText(FormatStatesRow(frame));
  if (problem_.empty()) ++rows_;
}

void StateStream::WriteText(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written > 0) rest.remove_prefix(static_cast<size_t>(written));
    if (written >= 0 || errno == EINTR) continue;
    const std::string fault =
        errno == EPIPE ? "its reader is gone" : std::generic_category().message(errno);
    problem_ = "stream to " + path_ + " ended after " + std::to_string(rows_) + " rows: " + fault;
    return;
  }
}

}  // namespace tagtwist
