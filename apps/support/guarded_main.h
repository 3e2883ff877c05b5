#pragma once
#include "apps/support/usage.h"

namespace tagtwist::internal {

/// What a main() returns: the status of `body`, which gets what `usage` says; or 1, told in one
/// line, where memory ran out, whatever else was thrown, or standard output did not take all that
/// was printed. Descriptors 0 to 2 that are closed lead to nowhere, so that no file that is opened
/// gets what is printed. Begins to log by glog.
int GuardedMain(int argc, char** argv, Usage (*usage)(),
                int (*body)(int argc, char** argv, const Usage& usage));

}  // namespace tagtwist::internal
