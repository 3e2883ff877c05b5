#pragma once
#include <functional>

namespace tagtwist {

/// From now on Ctrl-C (SIGINT, SIGTERM) does not end the process: the function that is returned
/// says true after it. A second one ends the process.
std::function<bool()> CatchInterrupts();

}  // namespace tagtwist
