#pragma once
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// The topic to take out of those that would do. Errors (without the bag's name) list them and what
/// a mistyped one may mean.
Result<std::string> ChooseImageTopic(const std::vector<std::string>& topics,
                                     const std::string& wanted);

/// Where a bag's ground truth comes from.
struct TruthTopic {
  std::string name;  // empty: none is taken
  std::string note;  // what a person must know of it; empty: nothing
};
/// The wanted topic, else the only one. Several and none wanted: none, and a note that lists them.
Result<TruthTopic> ChooseTruthTopic(const std::vector<std::string>& topics,
                                    const std::string& wanted);

}  // namespace tagtwist::internal
