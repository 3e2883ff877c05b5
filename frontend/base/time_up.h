#pragma once
#include <functional>

namespace tagtwist {

/// True when the time for what is being done is up; asked now and then by work that may stop early.
/// Whoever hands it down has the clock. Empty: never.
using TimeUp = std::function<bool()>;

inline bool IsUp(const TimeUp& time_up) { return time_up && time_up(); }

}  // namespace tagtwist
