#pragma once
#include <stdexcept>
#include <string>

/// Our own promises: what a function of ours owes another one. Data from users are not checked by
/// this; they get a Result. `what` names what is wrong, and is made only where something is.
/// Throws std::logic_error.
#define TAGTWIST_CHECK(condition, what)                                                     \
  do {                                                                                      \
    if (!(condition)) throw std::logic_error(std::string("broken promise: ").append(what)); \
  } while (false)
