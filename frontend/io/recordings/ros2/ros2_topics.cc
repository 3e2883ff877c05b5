#include "frontend/io/recordings/ros2/ros2_topics.h"

#include <algorithm>
#include <utility>

namespace tagtwist::internal {

Ros2TopicReader::Ros2TopicReader(const Ros2Bags& bags, std::string topic)
    : bags_(&bags), topic_(std::move(topic)) {}

Result<std::optional<Ros2Typed>> Ros2TopicReader::Next() {
  for (; file_ < bags_->size(); ++file_, cursor_.reset()) {
    const Ros2Bag& bag = *(*bags_)[file_];
    if (!cursor_) {
      std::vector<size_t> topics;
      for (size_t i = 0; i < bag.topics().size(); ++i) {
        if (bag.topics()[i].name == topic_) topics.push_back(i);
      }
      if (topics.empty()) continue;
      auto cursor = bag.Read(topics);
      if (!cursor) return cursor.error();
      cursor_ = std::move(*cursor);
    }
    auto message = cursor_->Next();
    if (!message) return message.error();
    if (*message) {
      return std::optional<Ros2Typed>({bag.topics()[(*message)->topic].type, std::move(**message)});
    }
  }
  return std::optional<Ros2Typed>();
}

std::vector<std::string> Ros2TopicsThat(const Ros2Bags& bags, bool (*fits)(const std::string&)) {
  std::vector<std::string> out;
  for (const auto& bag : bags) {
    for (const Ros2Topic& topic : bag->topics()) {
      if (fits(topic.type)) out.push_back(topic.name);
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace tagtwist::internal
