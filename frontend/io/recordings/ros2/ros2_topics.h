#pragma once
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/result.h"
#include "frontend/io/recordings/ros2/ros2_bag.h"

namespace tagtwist::internal {

using Ros2Bags = std::vector<std::unique_ptr<Ros2Bag>>;

/// A message with its topic's type.
struct Ros2Typed {
  std::string type;
  Ros2Message message;
};

/// The messages of one topic over all files, in their order; nullopt at the end.
class Ros2TopicReader {
 public:
  Ros2TopicReader(const Ros2Bags& bags, std::string topic);
  Result<std::optional<Ros2Typed>> Next();

 private:
  const Ros2Bags* bags_;
  std::string topic_;
  size_t file_ = 0;
  std::unique_ptr<Ros2Cursor> cursor_;
};

/// Names of the topics whose type fits, each once.
std::vector<std::string> Ros2TopicsThat(const Ros2Bags& bags, bool (*fits)(const std::string&));

}  // namespace tagtwist::internal
