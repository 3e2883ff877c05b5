#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/formats/ros2_writers.h"

namespace tagtwist::internal {

// A ROS 1 bag, format 2.0 (wiki.ros.org/Bags/Format/2.0), written record by record, one chunk
// without compression.

using Ros1Fields = std::vector<std::pair<std::string, std::string>>;

inline std::string Ros1Header(const Ros1Fields& fields) {
  std::string out;
  for (const auto& [name, value] : fields) out += Text(name + "=" + value);
  return out;
}

inline std::string Ros1Record(const Ros1Fields& fields, const std::string& data) {
  return Text(Ros1Header(fields)) + Text(data);
}

inline std::string Ros1Time(int64_t t_ns) {
  return Little(static_cast<uint32_t>(t_ns / 1'000'000'000)) +
         Little(static_cast<uint32_t>(t_ns % 1'000'000'000));
}

inline std::string Ros1Op(char op) { return {op}; }

inline std::string Ros1MessageHeader(int64_t t_ns) {
  return Little(uint32_t{0}) + Ros1Time(t_ns) + Text("cam");
}

inline std::string Ros1Image(int64_t t_ns) {
  return Ros1MessageHeader(t_ns) + Little(uint32_t{6}) + Little(uint32_t{8}) + Text("mono8") +
         std::string(1, '\0') + Little(uint32_t{8}) + Text(std::string(48, '\x55'));
}

inline std::string Ros1Doubles(const std::vector<double>& numbers) {
  return {reinterpret_cast<const char*>(numbers.data()), 8 * numbers.size()};
}

inline std::string Ros1Pose(int64_t t_ns) {
  return Ros1MessageHeader(t_ns) + Ros1Doubles({1, 2, 3, 0, 0, 0, 1});
}

inline std::string Ros1Imu(int64_t t_ns) {
  std::vector<double> numbers(37, 0.25);
  return Ros1MessageHeader(t_ns) + Ros1Doubles(numbers);
}

struct Ros1Topic {
  std::string name, type, md5;
  std::string (*message)(int64_t t_ns);
};

inline std::string Ros1Connection(size_t number, const Ros1Topic& topic) {
  const Ros1Fields data = {{"topic", topic.name},
                           {"type", topic.type},
                           {"md5sum", topic.md5},
                           {"message_definition", "none"}};
  return Ros1Record(
      {{"conn", Little(static_cast<uint32_t>(number))}, {"op", Ros1Op(7)}, {"topic", topic.name}},
      Ros1Header(data));
}

/// Three images, poses and IMU samples.
inline std::string Ros1Bag() {
  const std::vector<Ros1Topic> topics = {
      {"/cam", "sensor_msgs/Image", "060021388200f6f0f447d0fcd9c64743", Ros1Image},
      {"/body", "geometry_msgs/PoseStamped", "d3812c3cbc69362b77dc0b19b345f8f5", Ros1Pose},
      {"/imu", "sensor_msgs/Imu", "6a62c6daae103f4ff57a132d6f95cec2", Ros1Imu}};
  std::string chunk, connections, counts;
  std::vector<std::string> indices(topics.size());
  const int64_t first_ns = 10'000'000'000, last_ns = first_ns + 200'000'000;
  for (size_t i = 0; i < topics.size(); ++i) {
    const std::string connection = Ros1Connection(i, topics[i]);
    chunk += connection;
    connections += connection;
    for (int64_t t_ns = first_ns; t_ns <= last_ns; t_ns += 100'000'000) {
      indices[i] += Ros1Time(t_ns) + Little(static_cast<uint32_t>(chunk.size()));
      chunk += Ros1Record(
          {{"op", Ros1Op(2)}, {"conn", Little(static_cast<uint32_t>(i))}, {"time", Ros1Time(t_ns)}},
          topics[i].message(t_ns));
    }
    counts += Little(static_cast<uint32_t>(i)) + Little(uint32_t{3});
  }
  const std::string magic = "#ROSBAG V2.0\n";
  constexpr size_t kHead = 4096;
  const auto place = static_cast<uint64_t>(magic.size() + kHead);
  std::string body = Ros1Record({{"op", Ros1Op(5)},
                                 {"compression", "none"},
                                 {"size", Little(static_cast<uint32_t>(chunk.size()))}},
                                chunk);
  for (size_t i = 0; i < topics.size(); ++i) {
    body += Ros1Record({{"op", Ros1Op(4)},
                        {"ver", Little(uint32_t{1})},
                        {"conn", Little(static_cast<uint32_t>(i))},
                        {"count", Little(uint32_t{3})}},
                       indices[i]);
  }
  const Ros1Fields head = {{"op", Ros1Op(3)},
                           {"index_pos", Little(place + body.size())},
                           {"conn_count", Little(uint32_t{3})},
                           {"chunk_count", Little(uint32_t{1})}};
  const std::string padding(kHead - 8 - Ros1Header(head).size(), ' ');
  const std::string info = Ros1Record({{"op", Ros1Op(6)},
                                       {"ver", Little(uint32_t{1})},
                                       {"chunk_pos", Little(place)},
                                       {"start_time", Ros1Time(first_ns)},
                                       {"end_time", Ros1Time(last_ns)},
                                       {"count", Little(uint32_t{3})}},
                                      counts);
  return magic + Ros1Record(head, padding) + body + connections + info;
}

}  // namespace tagtwist::internal
