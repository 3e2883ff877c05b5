#include "apps/support/guarded_main.h"

#include <fcntl.h>
#include <glog/logging.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <iostream>
#include <new>
#include <system_error>

#include "frontend/base/result.h"

namespace tagtwist::internal {
namespace {

void OpenStandardDescriptors() {
  for (int descriptor = 0; descriptor <= STDERR_FILENO; ++descriptor) {
    if (::fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    if (::open("/dev/null", O_RDWR) < 0) return;  // takes the lowest that is free
  }
}

std::string OneLine(std::string text) {
  while (!text.empty() && text.back() == '\n') text.pop_back();
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  return text;
}

// A stream that failed says not why; the descriptor is asked again.
Status CheckStandardOutput() {
  if (std::cout.flush()) return Ok();
  const bool told = ::write(STDOUT_FILENO, "\n", 1) < 0;
  return Error{"standard output: cannot write" +
               (told ? ": " + std::generic_category().message(errno) : std::string())};
}

// Takes no memory: there may be none.
int FailBare(const char* program, const char* message) {
  const char* const slash = std::strrchr(program, '/');
  std::fprintf(stderr, "%s: %s\n", slash == nullptr ? program : slash + 1, message);
  return 1;
}

// Memory that ends where no exception may leave (a destructor, parts of the standard library) gets
// its line, too. Results are older or new ones then as after a kill.
[[noreturn]] void EndInOneLine() {
  const char* const program = program_invocation_short_name;
  int status = 1;
  try {
    if (std::current_exception()) throw;
    status = FailBare(program, "cannot go on: out of memory, or a fault that nobody caught");
  } catch (const std::bad_alloc&) {
    status = FailBare(program, "out of memory");
  } catch (...) {
    status = FailBare(program, "cannot go on: a fault that nobody caught");
  }
  ::_exit(status);
}

}  // namespace

int GuardedMain(int argc, char** argv, Usage (*usage)(),
                int (*body)(int argc, char** argv, const Usage& usage)) {
  OpenStandardDescriptors();
  std::set_terminate(EndInOneLine);
  try {
    google::InitGoogleLogging(argv[0]);
    const Usage known = usage();
    const int status = body(argc, argv, known);
    if (status != 0) return status;
    const auto written = CheckStandardOutput();
    return written ? 0 : Fail(known, written.error().message);
  } catch (const std::bad_alloc&) {
    return FailBare(argv[0], "out of memory");
  } catch (const std::exception& fault) {
    return FailBare(argv[0], ("cannot go on: " + OneLine(fault.what())).c_str());
  } catch (...) {
    return FailBare(argv[0], "cannot go on: an unknown fault");
  }
}

}  // namespace tagtwist::internal
