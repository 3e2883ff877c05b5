#include "frontend/io/recordings/bag_topics.h"

#include <algorithm>

#include "frontend/base/nearest_name.h"

namespace tagtwist::internal {
namespace {

std::string Listed(const std::vector<std::string>& topics) {
  std::string out;
  for (const std::string& topic : topics) out += (out.empty() ? "" : ", ") + topic;
  return out;
}

bool Has(const std::vector<std::string>& topics, const std::string& topic) {
  return std::find(topics.begin(), topics.end(), topic) != topics.end();
}

Error NoSuch(const std::string& what, const std::vector<std::string>& topics,
             const std::string& wanted) {
  return Error{"no " + what + " on the topic " + wanted + ": expected one of " + Listed(topics) +
               DidYouMean(wanted, topics)};
}

}  // namespace

Result<std::string> ChooseImageTopic(const std::vector<std::string>& topics,
                                     const std::string& wanted) {
  if (topics.empty()) return Error{"no images in the bag"};
  if (wanted.empty()) {
    if (topics.size() == 1) return topics.front();
    return Error{"several topics have images: expected --topic, one of " + Listed(topics)};
  }
  if (Has(topics, wanted)) return wanted;
  return NoSuch("images", topics, wanted);
}

Result<TruthTopic> ChooseTruthTopic(const std::vector<std::string>& topics,
                                    const std::string& wanted) {
  if (!wanted.empty()) {
    if (topics.empty()) return Error{"no poses in the bag for --truth_topic " + wanted};
    if (!Has(topics, wanted)) return NoSuch("poses", topics, wanted);
    return TruthTopic{wanted, ""};
  }
  if (topics.empty()) return TruthTopic{};
  if (topics.size() == 1) return TruthTopic{topics.front(), ""};
  return TruthTopic{"",
                    "several topics have poses, none is compared with: --truth_topic takes one "
                    "of " +
                        Listed(topics)};
}

}  // namespace tagtwist::internal
