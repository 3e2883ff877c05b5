// A library to preload: the n-th call of one kind fails, or ends the process before or after it.
// TAGTWIST_FAULT="rename:3", "write:1", "fsync:2", "read:5", "malloc:900"; "rename:3:kill" ends the
// process in the place of the third rename, after "rename:3:malloc" the next malloc fails. With
// "write:0" none fails, and at the end the file that TAGTWIST_FAULT_COUNT names gets how many there
// were. Counted is from the beginning of main to its end: what libraries do before is not a
// program's to answer for.
#include <dlfcn.h>
#include <fcntl.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>

extern "C" {
void* __libc_malloc(size_t size);  // NOLINT(readability-identifier-naming): the C library's
}

namespace {

using MainFunction = int(int, char**, char**);
std::atomic<bool> in_main{false};
MainFunction* program_main = nullptr;

int CountedMain(int argc, char** argv, char** environment) {
  in_main = true;
  const int status = program_main(argc, argv, environment);
  in_main = false;
  return status;
}

std::atomic<bool> next_malloc_fails{false};

// True when this call of the kind is the one to fail. Uses nothing that allocates.
bool IsNext(const char* kind, std::atomic<long>* count) {
  const char* const fault = std::getenv("TAGTWIST_FAULT");
  if (fault == nullptr || !in_main) return false;
  const size_t length = std::strlen(kind);
  if (std::strncmp(fault, kind, length) != 0 || fault[length] != ':') return false;
  char* end = nullptr;
  const long wanted = std::strtol(fault + length + 1, &end, 10);
  if (++*count != wanted) return false;
  if (std::strcmp(end, ":kill") == 0) ::kill(::getpid(), SIGKILL);
  next_malloc_fails = std::strcmp(end, ":malloc") == 0;
  return !next_malloc_fails;
}

std::atomic<long> writes{0}, reads{0}, renames{0}, syncs{0}, mallocs{0};

// The function of that name that this library stands before.
template <typename Function>
Function* Next(const char* name) {
  return reinterpret_cast<Function*>(::dlsym(RTLD_NEXT, name));
}

struct CountAtEnd {
  ~CountAtEnd() {
    const char* const path = std::getenv("TAGTWIST_FAULT_COUNT");
    if (path == nullptr) return;
    char text[24];
    long rest = writes + reads + renames + syncs + mallocs;  // but one is 0
    size_t at = sizeof(text);
    do {
      text[--at] = static_cast<char>('0' + rest % 10);
    } while ((rest /= 10) > 0);
    const int file = ::open(path, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    ::syscall(SYS_write, file, text + at, sizeof(text) - at);
    ::close(file);
  }
};
const CountAtEnd count_at_end;

}  // namespace

extern "C" {

// NOLINTNEXTLINE(readability-identifier-naming): the C library's, which calls main.
int __libc_start_main(MainFunction* main, int argc, char** argv, void (*init)(), void (*fini)(),
                      void (*loader)(), void* stack) {
  program_main = main;
  static auto* const next = Next<decltype(__libc_start_main)>("__libc_start_main");
  return next(CountedMain, argc, argv, init, fini, loader, stack);
}

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

ssize_t writev(int descriptor, const iovec* parts, int count) {
  if (descriptor > STDERR_FILENO && IsNext("write", &writes)) {
    errno = ENOSPC;
    return -1;
  }
  return ::syscall(SYS_writev, descriptor, parts, count);
}

// The C library's own streams write and read past the functions above.
size_t fwrite(const void* data, size_t size, size_t count, FILE* file) {
  static auto* const next = Next<decltype(fwrite)>("fwrite");
  if (file != stdout && file != stderr && IsNext("write", &writes)) {
    errno = ENOSPC;
    return 0;
  }
  return next(data, size, count, file);
}

size_t fread(void* data, size_t size, size_t count, FILE* file) {
  static auto* const next = Next<decltype(fread)>("fread");
  if (IsNext("read", &reads)) {
    errno = EIO;
    return 0;
  }
  return next(data, size, count, file);
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
  if (next_malloc_fails.exchange(false) || IsNext("malloc", &mallocs)) {
    errno = ENOMEM;
    return nullptr;
  }
  return __libc_malloc(size);
}

}  // extern "C"
