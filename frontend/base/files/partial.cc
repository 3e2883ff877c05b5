#include "frontend/base/files/partial.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <new>
#include <system_error>
#include <utility>

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;
constexpr int kMostTries = 1000;

// "dir/name" of "dir/name/"; a folder's own name where the path is ".".
fs::path TargetOf(const std::string& path) {
  fs::path target(path);
  return target.has_filename() ? target : target.parent_path();
}

std::string HiddenName(const fs::path& target) {
  return "." + target.filename().string() + ".partial-";
}

// A new file or folder, opened, or -1 and errno.
int MakeNew(const std::string& path, Partial::Kind kind) {
  if (kind == Partial::Kind::kFile) {
    return ::open(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
  }
  if (::mkdir(path.c_str(), 0777) != 0) return -1;
  return ::open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
}

// False where another process holds it, or has removed it meanwhile. Where a file system has no
// locks nobody can hold one, and nobody removes anything.
bool Lock(int descriptor) {
  if (::flock(descriptor, LOCK_EX | LOCK_NB) != 0) return errno != EWOULDBLOCK;
  struct stat status = {};
  return ::fstat(descriptor, &status) == 0 && status.st_nlink > 0;
}

// Entries beside the target whose names begin like its partial ones.
std::vector<fs::path> Neighbours(const fs::path& target, const std::string& beginning) {
  std::vector<fs::path> out;
  const fs::path folder = target.parent_path().empty() ? "." : target.parent_path();
  std::error_code failure;
  for (fs::directory_iterator entry(folder, failure), end; !failure && entry != end;
       entry.increment(failure)) {
    const std::string name = entry->path().filename().string();
    if (name.compare(0, beginning.size(), beginning) != 0) continue;
    out.push_back(target.parent_path() / name);
  }
  std::sort(out.begin(), out.end());
  return out;
}

bool IsLeftOver(const fs::path& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
  if (descriptor < 0) return false;
  const bool free = ::flock(descriptor, LOCK_EX | LOCK_NB) == 0;
  ::close(descriptor);
  return free;
}

}  // namespace

std::string PartialName(const std::string& path, int process) {
  const fs::path target = TargetOf(path);
  return (target.parent_path() / (HiddenName(target) + std::to_string(process))).string();
}

Result<Partial> Partial::Make(const std::string& path, Kind kind, const std::string& ending) {
  const std::string name = PartialName(path, ::getpid());
  for (int i = 1; i <= kMostTries; ++i) {
    // Named before it is made: no memory has to be found between the making and the return.
    Partial out(name + (i > 1 ? "-" + std::to_string(i) : "") + ending, -1);
    const int descriptor = MakeNew(out.path_, kind);
    const int failure = errno;
    if (descriptor >= 0 && Lock(descriptor)) {
      out.descriptor_ = descriptor;
      return out;
    }
    out.path_.clear();
    if (descriptor >= 0) {
      ::close(descriptor);
    } else if (failure != EEXIST) {
      return Error{path + ": cannot write: " + std::generic_category().message(failure)};
    }
  }
  return Error{path + ": cannot write: no free name beside it"};
}

Partial::Partial(Partial&& other) noexcept
    : path_(std::exchange(other.path_, "")), descriptor_(std::exchange(other.descriptor_, -1)) {}

Partial& Partial::operator=(Partial&& other) noexcept {
  if (this == &other) return *this;
  Remove();
  path_ = std::exchange(other.path_, "");
  descriptor_ = std::exchange(other.descriptor_, -1);
  return *this;
}

Partial::~Partial() { Remove(); }

// A file and an empty folder go without memory, of which there may be none.
void Partial::Remove() {
  try {
    std::error_code ignored;
    if (!path_.empty() && std::remove(path_.c_str()) != 0) fs::remove_all(path_, ignored);
  } catch (const std::bad_alloc&) {
    // The next run removes it.
  }
  if (descriptor_ >= 0) ::close(descriptor_);
}

int Partial::Rename(std::string path) {
  if (::rename(path_.c_str(), path.c_str()) != 0) return errno;
  path_ = std::move(path);
  return 0;
}

int Partial::PutAt(const std::string& path) {
  if (::rename(path_.c_str(), path.c_str()) != 0) return errno;
  path_.clear();
  return 0;
}

std::vector<std::string> RemoveLeftovers(const std::string& path) {
  const fs::path target = TargetOf(path);
  std::vector<std::string> out;
  for (const fs::path& left : Neighbours(target, HiddenName(target))) {
    std::error_code failure;
    if (IsLeftOver(left) && fs::remove_all(left, failure) > 0 && !failure) {
      out.push_back(left.string());
    }
  }
  return out;
}

void RemoveOwnPartials(const std::string& path) {
  const std::string own = PartialName(path, ::getpid());
  const fs::path target = TargetOf(path);
  for (const fs::path& partial : Neighbours(target, fs::path(own).filename().string())) {
    // Renamed first: what would be put in its place half removed is not found any more.
    const char next = partial.string().size() > own.size() ? partial.string()[own.size()] : '-';
    if (next != '-' && next != '.') continue;  // of another process, whose number is longer
    std::error_code failure;
    const fs::path ended = partial.string() + "-ended";
    fs::rename(partial, ended, failure);
    if (!failure) fs::remove_all(ended, failure);
  }
}

}  // namespace tagtwist::internal
