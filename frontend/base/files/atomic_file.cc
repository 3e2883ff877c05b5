#include "frontend/base/files/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <string_view>

#include "frontend/base/files/partial.h"

namespace tagtwist::internal {
namespace {

Error SystemError(const std::string& path, const std::string& what, int error_number) {
  return Error{path + ": " + what + ": " + std::strerror(error_number)};
}

// 0, or the errno of the first failed call. Closes the descriptor in any case.
int WriteAndClose(int descriptor, std::string_view content) {
  int failure = 0;
  while (!content.empty() && failure == 0) {
    const ssize_t written = ::write(descriptor, content.data(), content.size());
    if (written > 0) {
      content.remove_prefix(static_cast<size_t>(written));
    } else if (errno != EINTR) {
      failure = written == 0 ? EIO : errno;
    }
  }
  if (::close(descriptor) != 0 && failure == 0) failure = errno;
  return failure;
}

Status WriteDirectly(const std::string& path, const std::string& content) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (descriptor < 0) return SystemError(path, "cannot write", errno);
  const int failure = WriteAndClose(descriptor, content);
  if (failure != 0) return SystemError(path, "cannot write", failure);
  return Ok();
}

}  // namespace

Status WriteFileAtomically(const std::string& path, const std::string& content) {
  struct stat existing = {};
  if (::stat(path.c_str(), &existing) == 0 && !S_ISREG(existing.st_mode)) {
    return WriteDirectly(path, content);  // a folder is refused there
  }
  auto partial = Partial::Make(path, Partial::Kind::kFile);
  if (!partial) return partial.error();
  // A copy is closed, which tells of what failed late; the lock lasts until all is in place.
  int failure = WriteAndClose(::dup(partial->descriptor()), content);
  if (failure == 0) failure = partial->PutAt(path);
  return failure == 0 ? Ok() : SystemError(path, "cannot write", failure);
}

}  // namespace tagtwist::internal
