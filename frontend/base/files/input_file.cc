#include "frontend/base/files/input_file.h"

#include <sys/poll.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <system_error>
#include <utility>

namespace tagtwist::internal {
namespace {

Error InputError(const std::string& path, const std::string& what, int error_number) {
  return Error{path + ": " + what + ": " + std::generic_category().message(error_number)};
}

constexpr const char* kFileBytes = "file_bytes";

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

// What an open file is, with at most `bound` bytes where it says how many it has.
Result<struct stat> StatusOf(const std::string& path, const Descriptor& file, const Bound& bound) {
  struct stat status = {};
  if (file.number() < 0 || ::fstat(file.number(), &status) != 0) {
    return InputError(path, "cannot open", errno);
  }
  const char* const kind = KindOf(status.st_mode);
  if (kind == nullptr && status.st_size > bound.bytes) return TooLarge(path, bound);
  if (kind != nullptr && !S_ISFIFO(status.st_mode)) return NoFile(path, kind);
  return status;
}

Result<std::string> ReadBounded(const std::string& path, const Descriptor& file,
                                const struct stat& status, Bound bound, const Limits& limits) {
  std::string content;
  if (S_ISREG(status.st_mode)) {
    content.reserve(static_cast<size_t>(status.st_size));
    const int failure = ReadRegular(file.number(), bound.bytes, &content);
    if (failure != 0) return InputError(path, "cannot read", failure);
  } else {
    if (limits.pipe_bytes < bound.bytes) bound = {limits.pipe_bytes, "pipe_bytes"};
    const auto read = ReadPipe(path, file.number(), bound.bytes, limits, &content);
    if (!read) return read.error();
  }
  if (static_cast<int64_t>(content.size()) > bound.bytes) return TooLarge(path, bound);
  return content;
}

Result<std::string> ReadBounded(const std::string& path, const Bound& bound, const Limits& limits) {
  const Descriptor file(path);
  const auto status = StatusOf(path, file, bound);
  if (!status) return status.error();
  return ReadBounded(path, file, *status, bound, limits);
}

}  // namespace

Result<std::string> ReadWholeFile(const std::string& path, int64_t most, const Limits& limits) {
  return ReadBounded(path, {most, nullptr}, limits);
}

Result<std::string> ReadWholeFile(const std::string& path, const Limits& limits) {
  return ReadBounded(path, {limits.file_bytes, kFileBytes}, limits);
}

Result<std::string> ReadTextFile(const std::string& path, const Limits& limits) {
  return ReadBounded(path, {limits.text_bytes, "text_bytes"}, limits);
}

Result<PiecewiseFile> PiecewiseFile::Open(const std::string& path, const Limits& limits) {
  const Bound bound{limits.file_bytes, kFileBytes};
  PiecewiseFile out(path, bound.bytes);
  const auto status = StatusOf(path, *out.file_, bound);
  if (!status) return status.error();
  if (S_ISREG(status->st_mode)) return out;
  auto content = ReadBounded(path, *out.file_, *status, bound, limits);
  if (!content) return content.error();
  out.of_pipe_ = std::move(*content);
  return out;
}

// As ::pread.
ssize_t PiecewiseFile::ReadAt(int64_t offset, char* to, size_t most) const {
  if (!of_pipe_) return ::pread(file_->number(), to, most, offset);
  return static_cast<ssize_t>(of_pipe_->copy(to, most, static_cast<size_t>(offset)));
}

Result<bool> PiecewiseFile::AppendTo(std::string* out) {
  std::array<char, 65536> buffer;
  auto most = static_cast<int64_t>(buffer.size());
  if (size_) most = std::min(most, *size_ - offset_);
  if (most == 0) return false;
  ssize_t got = -1;
  do {
    got = ReadAt(offset_, buffer.data(), static_cast<size_t>(most));
  } while (got < 0 && errno == EINTR);
  if (got < 0) return InputError(path_, "cannot read", errno);
  if (got == 0 && size_) return Error{path_ + ": was made shorter while it was read"};
  if (got == 0) size_ = offset_;
  offset_ += got;
  if (offset_ > most_) return TooLarge(path_, {most_, kFileBytes});
  out->append(buffer.data(), static_cast<size_t>(got));
  return got > 0;
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
