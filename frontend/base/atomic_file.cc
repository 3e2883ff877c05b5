#include "frontend/base/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <memory>
#include <string_view>

namespace tagtwist {
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

std::string PartialNeighbour(const std::string& path) {
  std::filesystem::path target(path);
  if (!target.has_filename()) target = target.parent_path();  // "dir/name/"
  const std::string name = "." + target.filename().string() + ".partial-";
  std::filesystem::path partial;
  std::error_code ignored;
  int number = static_cast<int>(::getpid());
  do {
    partial = target.parent_path() / (name + std::to_string(number++));
  } while (std::filesystem::exists(std::filesystem::symlink_status(partial, ignored)));
  return partial.string();
}

Status WriteFileAtomically(const std::string& path, const std::string& content) {
  struct stat existing = {};
  if (::stat(path.c_str(), &existing) == 0 && !S_ISREG(existing.st_mode)) {
    return WriteDirectly(path, content);  // a folder is refused there
  }
  const std::string partial = PartialNeighbour(path);
  const int descriptor = ::open(partial.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
  if (descriptor < 0) return SystemError(path, "cannot write", errno);
  int failure = WriteAndClose(descriptor, content);
  if (failure == 0 && ::rename(partial.c_str(), path.c_str()) != 0) failure = errno;
  if (failure == 0) return Ok();
  ::unlink(partial.c_str());
  return SystemError(path, "cannot write", failure);
}

Result<std::string> ReadWholeFile(const std::string& path) {
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen(path.c_str(), "rbe"),
                                                             std::fclose);
  if (file == nullptr) return SystemError(path, "cannot open", errno);
  std::string content;
  std::array<char, 65536> buffer;
  size_t got = 0;
  while ((got = std::fread(buffer.data(), 1, buffer.size(), file.get())) > 0) {
    content.append(buffer.data(), got);
  }
  if (std::ferror(file.get()) != 0) return SystemError(path, "cannot read", errno);
  return content;
}

}  // namespace tagtwist
