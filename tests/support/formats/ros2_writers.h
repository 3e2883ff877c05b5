#pragma once
#include <fastcdr/Cdr.h>
#include <fastcdr/FastBuffer.h>
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace tagtwist::internal {

// ROS 2 bags, written record by record.

struct Message {
  std::string topic, type;
  int64_t arrival_ns = 0;
  std::string data;
};

inline const std::vector<std::string>& Topics() {
  static const std::vector<std::string> topics = {"/cam", "/body", "/imu"};
  return topics;
}
inline size_t IndexOf(const std::string& topic) {
  size_t i = 0;
  while (Topics()[i] != topic) ++i;
  return i;
}
inline std::string TypeOf(const std::vector<Message>& messages, const std::string& topic) {
  for (const Message& message : messages) {
    if (message.topic == topic) return message.type;
  }
  return "";
}

inline void WriteSqlite(const std::string& path, const std::vector<Message>& messages) {
  sqlite3* database = nullptr;
  ASSERT_EQ(sqlite3_open(path.c_str(), &database), SQLITE_OK);
  sqlite3_exec(database,
               "CREATE TABLE topics(id INTEGER PRIMARY KEY, name TEXT, type TEXT, "
               "serialization_format TEXT, offered_qos_profiles TEXT);"
               "CREATE TABLE messages(id INTEGER PRIMARY KEY, topic_id INTEGER, timestamp INTEGER, "
               "data BLOB);",
               nullptr, nullptr, nullptr);
  for (size_t i = 0; i < Topics().size(); ++i) {
    const std::string type = TypeOf(messages, Topics()[i]);
    if (type.empty()) continue;
    const std::string sql = "INSERT INTO topics VALUES(" + std::to_string(i + 1) + ",'" +
                            Topics()[i] + "','" + type + "','cdr','')";
    sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr);
  }
  sqlite3_stmt* insert = nullptr;
  sqlite3_prepare_v2(database, "INSERT INTO messages(topic_id,timestamp,data) VALUES(?,?,?)", -1,
                     &insert, nullptr);
  for (const Message& message : messages) {
    sqlite3_bind_int64(insert, 1, static_cast<int64_t>(IndexOf(message.topic)) + 1);
    sqlite3_bind_int64(insert, 2, message.arrival_ns);
    sqlite3_bind_blob(insert, 3, message.data.data(), static_cast<int>(message.data.size()),
                      SQLITE_TRANSIENT);
    sqlite3_step(insert);
    sqlite3_reset(insert);
  }
  sqlite3_finalize(insert);
  sqlite3_close(database);
}

template <typename Number>
inline std::string Little(Number number) {
  std::string out;
  for (size_t i = 0; i < sizeof(Number); ++i) {
    out += static_cast<char>(static_cast<uint64_t>(number) >> (8 * i) & 255U);
  }
  return out;
}
inline std::string Text(const std::string& text) {
  return Little(static_cast<uint32_t>(text.size())) + text;
}
inline std::string Record(uint8_t opcode, const std::string& content) {
  return Little(opcode) + Little(static_cast<uint64_t>(content.size())) + content;
}

inline std::string Compress(const std::string& compression, const std::string& text) {
  if (compression.empty()) return text;
  std::string out(LZ4F_compressFrameBound(text.size(), nullptr) + ZSTD_compressBound(text.size()),
                  0);
  const size_t size =
      compression == "lz4"
          ? LZ4F_compressFrame(out.data(), out.size(), text.data(), text.size(), nullptr)
          : ZSTD_compress(out.data(), out.size(), text.data(), text.size(), 3);
  out.resize(size);
  return out;
}

inline std::string Chunk(const std::string& compression, const std::string& records) {
  const auto sum = static_cast<uint32_t>(
      crc32(0, reinterpret_cast<const Bytef*>(records.data()), static_cast<uInt>(records.size())));
  const std::string packed = Compress(compression, records);
  return Record(0x06, Little(uint64_t{0}) + Little(uint64_t{0}) +
                          Little(static_cast<uint64_t>(records.size())) + Little(sum) +
                          Text(compression) + Little(static_cast<uint64_t>(packed.size())) +
                          packed);
}

// `compression`: "none" is without chunks.
inline std::string Mcap(const std::string& compression, const std::vector<Message>& messages) {
  const std::string magic("\x89MCAP0\r\n", 8);
  std::string records;
  for (size_t i = 0; i < Topics().size(); ++i) {
    const std::string type = TypeOf(messages, Topics()[i]);
    if (type.empty()) continue;
    const auto id = static_cast<uint16_t>(i + 1);
    records += Record(0x03, Little(id) + Text(type) + Text("ros2msg") + Text(""));
    records += Record(0x04, Little(id) + Little(id) + Text(Topics()[i]) + Text("cdr") + Text(""));
  }
  std::string chunked;
  for (const Message& message : messages) {
    const auto id = static_cast<uint16_t>(IndexOf(message.topic) + 1);
    const auto time = static_cast<uint64_t>(message.arrival_ns);
    records +=
        Record(0x05, Little(id) + Little(uint32_t{0}) + Little(time) + Little(time) + message.data);
    if (compression != "none" && records.size() > 200) {
      chunked += Chunk(compression == "plain" ? "" : compression, records);
      records.clear();
    }
  }
  return magic + Record(0x01, Text("ros2") + Text("test")) + chunked +
         (compression == "none" ? records
                                : Chunk(compression == "plain" ? "" : compression, records)) +
         Record(0x0F, Little(uint32_t{0})) +
         Record(0x02, Little(uint64_t{0}) + Little(uint64_t{0}) + Little(uint32_t{0})) + magic;
}

constexpr int kRos2Width = 8, kRos2Height = 6;

/// A message in CDR, value by value.
class Ros2Writer {
  using Cdr = eprosima::fastcdr::Cdr;

 public:
  Ros2Writer() : cdr_(buffer_, Cdr::DEFAULT_ENDIAN, Cdr::DDS_CDR) {
    cdr_.serialize_encapsulation();
  }
  template <typename Value>
  Ros2Writer& operator<<(const Value& value) {
    cdr_.serialize(value);
    return *this;
  }
  Ros2Writer& Header(double t_s) {
    const auto whole = static_cast<int32_t>(t_s);
    return *this << whole << static_cast<uint32_t>(std::llround(1e9 * (t_s - whole)))
                 << std::string("cam");
  }
  Ros2Writer& Zeros(int count) {
    for (int i = 0; i < count; ++i) *this << 0.0;
    return *this;
  }
  std::string Data() { return {buffer_.getBuffer(), cdr_.getSerializedDataLength()}; }

 private:
  eprosima::fastcdr::FastBuffer buffer_;
  Cdr cdr_;
};

inline std::string Ros2Image(double t_s, uint8_t grey) {
  Ros2Writer out;
  out.Header(t_s) << uint32_t{kRos2Height} << uint32_t{kRos2Width} << std::string("mono8")
                  << uint8_t{0} << uint32_t{kRos2Width}
                  << std::vector<uint8_t>(kRos2Width * kRos2Height, grey);
  return out.Data();
}
inline std::string Ros2Pose(double t_s, double x) {
  Ros2Writer out;
  out.Header(t_s) << x << 2.0 << 3.0 << 0.0 << 0.0 << 0.0 << 1.0;
  return out.Data();
}
inline std::string Ros2Imu(double t_s) {
  Ros2Writer out;
  out.Header(t_s).Zeros(13) << 0.1 << 0.2 << 0.3;
  out.Zeros(9) << 1.0 << 2.0 << 9.8;
  out.Zeros(9);
  return out.Data();
}

/// Five frames with a pose and an IMU sample each, 0.1 s apart.
inline std::vector<Message> Ros2Recording() {
  std::vector<Message> out;
  for (int i = 0; i < 5; ++i) {
    const double t_s = 10 + 0.1 * i;
    const int64_t arrival_ns = std::llround(1e9 * t_s) + 1000;
    out.push_back({"/cam", "sensor_msgs/msg/Image", arrival_ns,
                   Ros2Image(t_s, static_cast<uint8_t>(10 * i))});
    out.push_back({"/body", "geometry_msgs/msg/PoseStamped", arrival_ns, Ros2Pose(t_s, i)});
    out.push_back({"/imu", "sensor_msgs/msg/Imu", arrival_ns, Ros2Imu(t_s)});
  }
  return out;
}

}  // namespace tagtwist::internal
