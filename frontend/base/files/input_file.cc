#include "frontend/base/files/input_file.h"

#include <fcntl.h>
#include <sys/poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <system_error>

namespace tagtwist::internal {
namespace {

// A descriptor that is closed with its scope.
class Descriptor {
 public:
  explicit Descriptor(const std::string& path)
      : number_(::open(path.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC | O_NOCTTY)) {}
  ~Descriptor() {
    if (number_ >= 0) ::close(number_);
  }
  Descriptor(const Descriptor&) = delete;
  Descriptor& operator=(const Descriptor&) = delete;
  int number() const { return number_; }

 private:
  int number_;
};

Error InputError(const std::string& path, const std::string& what, int error_number) {
  return Error{path + ": " + what + ": " + std::generic_category().message(error_number)};
}

// What is read at most, and the limit's name; none where it is the format's own.
struct Bound {
  int64_t bytes;
  const char* name;
};

Error TooLarge(const std::string& path, const Bound& bound) {
  return Error{path + ": is larger than " + std::to_string(bound.bytes / 1'000'000) + " MB" +
               (bound.name == nullptr ? "" : RaisesLimit(bound.name))};
}

int Milliseconds(double seconds) { return static_cast<int>(std::min(1e3 * seconds, 1e9)); }

Error NoFile(const std::string& path, const char* kind) {
  return Error{path + ": expected a file, got " + kind};
}

// "a pipe"; nullptr for a regular file.
const char* KindOf(mode_t mode) {
  if (S_ISREG(mode)) return nullptr;
  if (S_ISDIR(mode)) return "a folder";
  if (S_ISFIFO(mode)) return "a pipe";
  if (S_ISSOCK(mode)) return "a socket";
  return "a device";
}

// 0, or the errno of the read that failed.
int ReadRegular(int descriptor, int64_t most, std::string* out) {
  std::array<char, 65536> buffer;
  while (static_cast<int64_t>(out->size()) <= most) {
    const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
    if (got > 0) out->append(buffer.data(), static_cast<size_t>(got));
    if (got == 0) return 0;
    if (got < 0 && errno != EINTR) return errno;
  }
  return 0;
}

// A pipe's read returns nothing, too, as long as no writer has opened it.
Status ReadPipe(const std::string& path, int descriptor, int64_t most, const Limits& limits,
                std::string* out) {
  std::array<char, 65536> buffer;
  const int idle_ms = Milliseconds(limits.pipe_idle_s);
  const int start_ms = Milliseconds(limits.pipe_start_s);  // a writer may start a moment later
  int waited_ms = 0;
  while (static_cast<int64_t>(out->size()) <= most) {
    const ssize_t got = ::read(descriptor, buffer.data(), buffer.size());
    if (got > 0) {
      out->append(buffer.data(), static_cast<size_t>(got));
      waited_ms = 0;
      continue;
    }
    if (got < 0 && errno != EAGAIN && errno != EINTR) {
      return InputError(path, "cannot read", errno);
    }
    if (got == 0 && (!out->empty() || waited_ms >= start_ms)) return Ok();
    if (waited_ms >= idle_ms) return Error{path + ": is a pipe, and nothing comes out of it"};
    constexpr int kStepMs = 20;
    pollfd ready{descriptor, POLLIN, 0};
    ::poll(&ready, 1, kStepMs);
    // Of a pipe whose writer is gone poll returns at once.
    if ((ready.revents & POLLHUP) != 0) ::usleep(1000 * kStepMs);
    waited_ms += kStepMs;
  }
  return Ok();
}

Result<std::string> ReadBounded(const std::string& path, Bound bound, const Limits& limits) {
  const Descriptor file(path);
  struct stat status = {};
  if (file.number() < 0 || ::fstat(file.number(), &status) != 0) {
    return InputError(path, "cannot open", errno);
  }
  const char* const kind = KindOf(status.st_mode);
  std::string content;
  if (kind == nullptr) {
    if (status.st_size > bound.bytes) return TooLarge(path, bound);
    content.reserve(static_cast<size_t>(status.st_size));
    const int failure = ReadRegular(file.number(), bound.bytes, &content);
    if (failure != 0) return InputError(path, "cannot read", failure);
  } else if (S_ISFIFO(status.st_mode)) {
    if (limits.pipe_bytes < bound.bytes) bound = {limits.pipe_bytes, "pipe_bytes"};
    const auto read = ReadPipe(path, file.number(), bound.bytes, limits, &content);
    if (!read) return read.error();
  } else {
    return NoFile(path, kind);
  }
  if (static_cast<int64_t>(content.size()) > bound.bytes) return TooLarge(path, bound);
  return content;
}

}  // namespace

Result<std::string> ReadWholeFile(const std::string& path, int64_t most, const Limits& limits) {
  return ReadBounded(path, {most, nullptr}, limits);
}

Result<std::string> ReadWholeFile(const std::string& path, const Limits& limits) {
  return ReadBounded(path, {limits.file_bytes, "file_bytes"}, limits);
}

Result<std::string> ReadTextFile(const std::string& path, const Limits& limits) {
  return ReadBounded(path, {limits.text_bytes, "text_bytes"}, limits);
}

std::string FirstBytes(const std::string& path, size_t count) {
  struct stat status = {};
  std::string out;
  // To open a pipe and to close it again would end its writer.
  if (::stat(path.c_str(), &status) != 0 || !S_ISREG(status.st_mode)) return out;
  const Descriptor file(path);
  if (file.number() < 0) return out;
  out.resize(count);
  const ssize_t got = ::pread(file.number(), out.data(), count, 0);
  out.resize(static_cast<size_t>(std::max<ssize_t>(got, 0)));
  return out;
}

Status CheckRegularFile(const std::string& path) {
  struct stat status = {};
  if (::stat(path.c_str(), &status) != 0) return Ok();
  const char* const kind = KindOf(status.st_mode);
  if (kind == nullptr) return Ok();
  return NoFile(path, kind);
}

}  // namespace tagtwist::internal
