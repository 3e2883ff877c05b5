#include "frontend/base/files/growing_file.h"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace tagtwist::internal {
namespace {

constexpr size_t kMostWaiting = 64 * 1024;

Error NotWritten(const std::string& path, int error_number) {
  return Error{path + ": cannot write: " + std::strerror(error_number)};
}

}  // namespace

Result<GrowingFile> GrowingFile::Make(const std::string& path) {
  const int descriptor =
      ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  if (descriptor < 0) return NotWritten(path, errno);
  return GrowingFile(path, descriptor);
}

GrowingFile::GrowingFile(GrowingFile&& other) noexcept
    : path_(std::move(other.path_)),
      waiting_(std::move(other.waiting_)),
      descriptor_(std::exchange(other.descriptor_, -1)) {}

GrowingFile& GrowingFile::operator=(GrowingFile&& other) noexcept {
  std::swap(path_, other.path_);
  std::swap(waiting_, other.waiting_);
  std::swap(descriptor_, other.descriptor_);
  return *this;
}

GrowingFile::~GrowingFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

Status GrowingFile::Append(std::string_view text) {
  waiting_ += text;
  return waiting_.size() < kMostWaiting ? Ok() : Write();
}

Status GrowingFile::Write() {
  std::string_view rest = waiting_;
  while (!rest.empty()) {
    const ssize_t written = ::write(descriptor_, rest.data(), rest.size());
    if (written > 0) {
      rest.remove_prefix(static_cast<size_t>(written));
    } else if (written == 0 || errno != EINTR) {
      return NotWritten(path_, written == 0 ? EIO : errno);
    }
  }
  waiting_.clear();
  return Ok();
}

Status GrowingFile::Close() {
  if (descriptor_ < 0) return Ok();
  if (const Status written = Write(); !written) return written;
  if (::close(std::exchange(descriptor_, -1)) != 0) return NotWritten(path_, errno);
  return Ok();
}

}  // namespace tagtwist::internal
