#include "apps/estimate/interrupt.h"

#include <csignal>

namespace tagtwist {
namespace {

// What a handler may touch has to be of the process.
volatile std::sig_atomic_t interrupted = 0;

}  // namespace

std::function<bool()> CatchInterrupts() {
  struct sigaction action = {};
  action.sa_handler = [](int) { interrupted = 1; };
  action.sa_flags = SA_RESETHAND;
  sigaction(SIGINT, &action, nullptr);
  sigaction(SIGTERM, &action, nullptr);
  return [] { return interrupted != 0; };
}

}  // namespace tagtwist
