#include "frontend/io/recordings/bag_topics.h"

#include <algorithm>
#include <utility>

#include "frontend/base/nearest_name.h"
#include "frontend/base/printable.h"

namespace tagtwist::internal {
namespace {

std::string Listed(const std::vector<std::string>& topics) {
  std::string out;
  for (const std::string& topic : topics) out += (out.empty() ? "" : ", ") + Printable(topic);
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

Result<std::string> Choose(const std::string& what, const std::string& flag,
                           const std::vector<std::string>& topics, const std::string& wanted) {
  if (wanted.empty()) {
    if (topics.size() == 1) return topics.front();
    return Error{"several topics have " + what + ": expected " + flag + ", one of " +
                 Listed(topics)};
  }
  if (Has(topics, wanted)) return wanted;
  return NoSuch(what, topics, wanted);
}

}  // namespace

Result<std::string> ChooseImageTopic(const std::vector<std::string>& topics,
                                     const std::string& wanted) {
  if (topics.empty()) {
    return Error{
        "no images in the bag (sensor_msgs Image or CompressedImage): look what was "
        "recorded with rosbag info or ros2 bag info"};
  }
  return Choose("images", "--topic", topics, wanted);
}

Result<std::string> ChooseCameraTopic(const std::vector<std::string>& topics,
                                      const std::string& wanted) {
  if (topics.empty()) {
    return Error{"no camera_info in the bag: give the calibration as a file of its own"};
  }
  return Choose("camera_info", "--camera", topics, wanted);
}

namespace {

Result<TruthTopic> ChooseTransforms(const std::vector<std::string>& trees,
                                    const std::string& wanted, size_t colon) {
  const std::string topic = wanted.substr(0, colon);
  if (trees.empty()) return Error{"no transforms in the bag for --truth_topic " + wanted};
  if (!Has(trees, topic)) return NoSuch("transforms", trees, topic);
  return TruthTopic{topic, "", wanted.substr(colon + 1)};
}

}  // namespace

std::string TruthTopic::Origin() const {
  if (name.empty()) return "";
  return Printable(child.empty() ? "topic " + name : "transforms of " + child + " on " + name);
}

Result<TruthTopic> ChooseTruth(const std::vector<std::string>& topics,
                               const std::vector<std::string>& trees, const std::string& wanted) {
  const size_t colon = wanted.find(':');
  if (colon != std::string::npos) return ChooseTransforms(trees, wanted, colon);
  if (!wanted.empty() && Has(trees, wanted)) {
    return Error{"the topic " + wanted + " has transforms: --truth_topic " + wanted +
                 ":CHILD takes those of a frame"};
  }
  if (!wanted.empty()) {
    if (topics.empty()) return Error{"no poses in the bag for --truth_topic " + wanted};
    if (!Has(topics, wanted)) return NoSuch("poses", topics, wanted);
    return TruthTopic{wanted, ""};
  }
  if (topics.size() == 1) return TruthTopic{topics.front(), ""};
  if (!topics.empty()) {
    return TruthTopic{"",
                      "several topics have poses, none is compared with: --truth_topic takes one "
                      "of " +
                          Listed(topics)};
  }
  if (trees.empty()) return TruthTopic{};
  return TruthTopic{"", "no topic has poses; of the transforms on " + Printable(trees.front()) +
                            " --truth_topic " + Printable(trees.front()) +
                            ":CHILD takes those of a frame"};
}

TransformsOfFrame::TransformsOfFrame(TruthTopic topic) : topic_(std::move(topic)) {}

void TransformsOfFrame::Add(const std::vector<FrameTransform>& transforms) {
  for (const auto& [child, sample] : transforms) {
    children_.insert(child);
    const bool grows = taken_.empty() || sample.t_ns > taken_.back().t_ns;
    if (child == topic_.child && grows) taken_.push_back(sample);
  }
}

Result<std::vector<TruthSample>> TransformsOfFrame::Take() {
  if (!taken_.empty()) return std::move(taken_);
  return Error{"no transform of " + topic_.child + " on " + topic_.name + ": expected one of " +
               Listed({children_.begin(), children_.end()})};
}

}  // namespace tagtwist::internal
