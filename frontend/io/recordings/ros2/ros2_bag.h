#pragma once
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "frontend/base/limits.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A topic of a ROS 2 bag: "/cam0/image_raw", "sensor_msgs/msg/Image".
struct Ros2Topic {
  std::string name, type;
};

/// A message as it was recorded: CDR with its four bytes of encapsulation.
struct Ros2Message {
  size_t topic = 0;        // index in Ros2Bag::topics()
  int64_t arrival_ns = 0;  // when the recorder had it
  std::vector<uint8_t> data;
};

/// The messages of some topics, one at a time, in order of arrival.
class Ros2Cursor {
 public:
  virtual ~Ros2Cursor() = default;
  /// nullopt at the end; an error names the file and the damage.
  virtual Result<std::optional<Ros2Message>> Next() = 0;
};

/// One file of a ROS 2 bag, sqlite3 (.db3) or MCAP (.mcap), read without ROS.
class Ros2Bag {
 public:
  virtual ~Ros2Bag() = default;
  virtual const std::vector<Ros2Topic>& topics() const = 0;
  virtual Result<std::unique_ptr<Ros2Cursor>> Read(const std::vector<size_t>& topics) const = 0;
};

/// Refused: what SQLite cannot read, a database without a bag's tables, messages that are not CDR.
Result<std::unique_ptr<Ros2Bag>> OpenRos2Sqlite(const std::string& path);

/// Chunked or not, with lz4, zstd or no compression, with an index or without: the records are read
/// through once. Refused: a file that is cut or was not ended, checksums that do not fit, sizes
/// that no record has. Messages in other encodings than cdr are passed over.
Result<std::unique_ptr<Ros2Bag>> OpenRos2Mcap(const std::string& path, const Limits& limits = {});

/// True when the file begins as one of them does.
bool IsRos2Sqlite(const std::string& path);
bool IsRos2Mcap(const std::string& path);

}  // namespace tagtwist::internal
