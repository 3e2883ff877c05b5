#pragma once
#include <functional>
#include <optional>
#include <string>

#include "apps/support/usage.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// What a benchmark's main does: parses the flags, asks `flag_problem` ("--seeds: expected ..."),
/// measures. Returns the process's status: 0; 1 for a fault, told in one line; 2 for wrong usage.
int RunBench(int argc, char** argv, const Usage& usage,
             const std::function<std::optional<std::string>()>& flag_problem,
             const std::function<Status()>& measure);

}  // namespace tagtwist::internal
