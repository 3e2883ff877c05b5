#include "apps/estimate/state_stream.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <string_view>
#include <system_error>
#include <utility>

#include "estimator/report/files/states_csv.h"

namespace tagtwist::internal {
namespace {

// As ::write, but a pipe whose reader is gone is an error (EPIPE) and no signal, in this thread and
// for this write alone: the process keeps its ways with SIGPIPE.
ssize_t WriteWithoutSigpipe(int descriptor, std::string_view text) {
  sigset_t sigpipe, before, pending;
  sigemptyset(&sigpipe);
  sigaddset(&sigpipe, SIGPIPE);
  sigpending(&pending);
  const bool was_pending = sigismember(&pending, SIGPIPE) == 1;
  pthread_sigmask(SIG_BLOCK, &sigpipe, &before);
  const ssize_t written = ::write(descriptor, text.data(), text.size());
  const int failure = errno;
  if (written < 0 && failure == EPIPE && !was_pending) {
    const timespec at_once = {};
    while (sigtimedwait(&sigpipe, nullptr, &at_once) < 0 && errno == EINTR) {
    }
  }
  pthread_sigmask(SIG_SETMASK, &before, nullptr);
  errno = failure;
  return written;
}

}  // namespace

Result<std::unique_ptr<StateStream>> StateStream::Open(const std::string& path, bool names_bodies) {
  const bool to_stdout = path == "-";
  const int descriptor = to_stdout
                             ? STDOUT_FILENO
                             : ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0)
    return Error{path + ": cannot write: " + std::generic_category().message(errno)};
  std::unique_ptr<StateStream> out(
      new StateStream(to_stdout ? "standard output" : path, descriptor, names_bodies));
  out->WriteRow(StatesCsvHeader(), "body");
  return out;
}

StateStream::StateStream(std::string path, int descriptor, bool names_bodies)
    : path_(std::move(path)), descriptor_(descriptor), names_bodies_(names_bodies) {}

StateStream::~StateStream() {
  if (descriptor_ != STDOUT_FILENO) ::close(descriptor_);
}

void StateStream::Write(const FrameEstimate& frame, const std::string& body) {
  if (!problem_.empty()) return;
  WriteRow(FormatStatesRow(frame), body);
  if (problem_.empty()) ++rows_;
}

// `line`: with its end.
void StateStream::WriteRow(std::string line, const std::string& body) {
  if (names_bodies_) line.insert(line.size() - 1, "," + body);
  WriteText(line);
}

void StateStream::WriteText(const std::string& text) {
  std::string_view rest = text;
  while (!rest.empty()) {
    const ssize_t written = WriteWithoutSigpipe(descriptor_, rest);
    if (written > 0) rest.remove_prefix(static_cast<size_t>(written));
    if (written >= 0 || errno == EINTR) continue;
    failed_ = errno != EPIPE;
    const std::string fault =
        failed_ ? std::generic_category().message(errno) : std::string("its reader is gone");
    problem_ = "stream to " + path_ + " ended after " + std::to_string(rows_) + " rows: " + fault;
    return;
  }
}

}  // namespace tagtwist::internal
