#include "frontend/base/files/file_set_commit.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <sstream>

namespace tagtwist::internal {

std::string FormatCommitPlan(const CommitPlan& plan) {
  std::string out;
  for (const std::string& name : plan.put) out += "put " + name + "\n";
  for (const std::string& name : plan.remove) out += "remove " + name + "\n";
  return out;
}

CommitPlan ParseCommitPlan(const std::string& text) {
  CommitPlan out;
  std::istringstream lines(text);
  for (std::string verb, name; lines >> verb && std::getline(lines >> std::ws, name);) {
    if (name.find('/') != std::string::npos || name == "." || name == "..") continue;
    if (verb == "put") out.put.push_back(name);
    if (verb == "remove") out.remove.push_back(name);
  }
  return out;
}

CommitLock::CommitLock(const std::string& commit)
    : descriptor_(::open(commit.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC)) {}

CommitLock::~CommitLock() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

bool CommitLock::Take() const { return ::flock(descriptor_, LOCK_EX | LOCK_NB) == 0; }

int MoveAll(const std::vector<FileMove>& moves, size_t* failed) noexcept {
  for (size_t i = 0; i < moves.size(); ++i) {
    if (std::rename(moves[i].from.c_str(), moves[i].to.c_str()) == 0) continue;
    const int failure = errno;
    for (size_t k = i; k-- > 0;) std::rename(moves[k].to.c_str(), moves[k].from.c_str());
    *failed = i;
    return failure;
  }
  return 0;
}

int FlushToDisk(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (descriptor < 0) return errno;
  int failure = ::fsync(descriptor) == 0 ? 0 : errno;
  if (failure == EINVAL || failure == EROFS || failure == ENOSYS) failure = 0;  // it has no such
  ::close(descriptor);
  return failure;
}

}  // namespace tagtwist::internal
