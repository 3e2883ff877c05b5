// A library to preload: the n-th call of one kind fails, or ends the process before or after it.
// TAGTWIST_FAULT="rename:3", "write:1", "fsync:2", "read:5", "malloc:900"; "rename:3:kill" ends the
// process in the place of the third rename.
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(size_t size);  // NOLINT(readability-identifier-naming): the C library's
}

namespace {

// True when this call of the kind is the one to fail. Uses nothing that allocates.
bool IsNext(const char* kind, std::atomic<long>* count) {
  const char* const fault = std::getenv("TAGTWIST_FAULT");
  if (fault == nullptr) return false;
  const size_t length = std::strlen(kind);
  if (std::strncmp(fault, kind, length) != 0 || fault[length] != ':') return false;
  char* end = nullptr;
  const long wanted = std::strtol(fault + length + 1, &end, 10);
  if (++*count != wanted) return false;
  if (std::strcmp(end, ":kill") == 0) ::kill(::getpid(), SIGKILL);
  return true;
}

std::atomic<long> writes{0}, reads{0}, renames{0}, syncs{0}, mallocs{0};

}  // namespace

extern "C" {

ssize_t write(int descriptor, const void* data, size_t size) {
  if (descriptor > STDERR_FILENO && IsNext("write", &writes)) {
    errno = ENOSPC;
    return -1;
  }
  return ::syscall(SYS_write, descriptor, data, size);
}

ssize_t read(int descriptor, void* data, size_t size) {
  if (IsNext("read", &reads)) {
    errno = EIO;
    return -1;
  }
  return ::syscall(SYS_read, descriptor, data, size);
}

int rename(const char* from, const char* to) noexcept {
  if (IsNext("rename", &renames)) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, 0));
}

int fsync(int descriptor) {
  if (IsNext("fsync", &syncs)) {
    errno = EIO;
    return -1;
  }
  return static_cast<int>(::syscall(SYS_fsync, descriptor));
}

void* malloc(size_t size) noexcept {
  if (IsNext("malloc", &mallocs)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_malloc(size);
}

}  // extern "C"
