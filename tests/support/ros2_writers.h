#pragma once
#include <gtest/gtest.h>
#include <lz4frame.h>
#include <sqlite3.h>
#include <zlib.h>
#include <zstd.h>

#include <cstdint>
#include <string>
#include <vector>

namespace tagtwist {

// ROS 2 bags, written record by record.

struct Message {
  std::string topic, type;
  int64_t arrival_ns = 0;
  std::string data;
};

inline const std::vector<std::string>& Topics() {
  static const std::vector<std::string> kTopics = {"/cam", "/body", "/imu"};
  return kTopics;
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

}  // namespace tagtwist
