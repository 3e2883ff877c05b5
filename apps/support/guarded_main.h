#pragma once
#include <functional>

#include "apps/support/usage.h"

namespace tagtwist::internal {

/// What a main() returns: the status of `body`; or 1, told in one line, where memory ran out,
/// whatever else was thrown, or standard output did not take all that was printed. Descriptors 0 to
/// 2 that are closed lead to nowhere, so that no file that is opened gets what is printed.
int GuardedMain(const Usage& usage, const std::function<int()>& body);

}  // namespace tagtwist::internal
