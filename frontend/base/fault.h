#pragma once
#include <string>

namespace tagtwist::internal {

/// A mistake that a person made in setting up a run, as the run itself tells of it.
struct Fault {
  std::string fact;    // a sentence
  std::string advice;  // a sentence
};

}  // namespace tagtwist::internal
