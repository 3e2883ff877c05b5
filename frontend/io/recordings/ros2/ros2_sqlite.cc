#include <sqlite3.h>

#include <algorithm>
#include <array>
#include <fstream>
#include <string_view>
#include <utility>

#include "frontend/base/printable.h"
#include "frontend/io/recordings/ros2/ros2_bag.h"

namespace tagtwist::internal {
namespace {

struct CloseDatabase {
  void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
};
struct FinaliseStatement {
  void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
};
using Database = std::shared_ptr<sqlite3>;
using Statement = std::unique_ptr<sqlite3_stmt, FinaliseStatement>;

Error Damaged(const std::string& path, sqlite3* database) {
  return Error{path + ": no ROS 2 bag, or a damaged one: " + Printable(sqlite3_errmsg(database))};
}

Result<Statement> Prepare(const std::string& path, sqlite3* database, const std::string& sql) {
  sqlite3_stmt* statement = nullptr;
  if (sqlite3_prepare_v2(database, sql.c_str(), -1, &statement, nullptr) != SQLITE_OK) {
    return Damaged(path, database);
  }
  return Statement(statement);
}

std::string Text(sqlite3_stmt* statement, int column) {
  const unsigned char* text = sqlite3_column_text(statement, column);
  return text == nullptr ? "" : reinterpret_cast<const char*>(text);
}

class SqliteCursor : public Ros2Cursor {
 public:
  SqliteCursor(std::string path, Database database, Statement statement,
               std::vector<int64_t> topic_ids)
      : path_(std::move(path)),
        database_(std::move(database)),
        statement_(std::move(statement)),
        topic_ids_(std::move(topic_ids)) {}

  Result<std::optional<Ros2Message>> Next() override {
    const int state = sqlite3_step(statement_.get());
    if (state == SQLITE_DONE) return std::optional<Ros2Message>();
    if (state != SQLITE_ROW) return Damaged(path_, database_.get());
    Ros2Message out;
    const int64_t id = sqlite3_column_int64(statement_.get(), 0);
    out.topic = static_cast<size_t>(std::find(topic_ids_.begin(), topic_ids_.end(), id) -
                                    topic_ids_.begin());
    out.arrival_ns = sqlite3_column_int64(statement_.get(), 1);
    const auto* data = static_cast<const uint8_t*>(sqlite3_column_blob(statement_.get(), 2));
    const int size = sqlite3_column_bytes(statement_.get(), 2);
    if (data != nullptr) out.data.assign(data, data + size);
    return std::optional<Ros2Message>(std::move(out));
  }

 private:
  std::string path_;
  Database database_;  // outlives the statement
  Statement statement_;
  std::vector<int64_t> topic_ids_;
};

class SqliteBag : public Ros2Bag {
 public:
  SqliteBag(std::string path, Database database)
      : path_(std::move(path)), database_(std::move(database)) {}

  Status ReadTopics() {
    auto statement = Prepare(path_, database_.get(),
                             "SELECT id, name, type, serialization_format FROM topics ORDER BY id");
    if (!statement) return statement.error();
    int state = SQLITE_ROW;
    while ((state = sqlite3_step(statement->get())) == SQLITE_ROW) {
      const std::string format = Text(statement->get(), 3);
      if (format != "cdr") {
        return Error{path_ + ": expected messages in cdr, got " + Printable(format) +
                     ": ros2 bag convert writes such ones"};
      }
      topic_ids_.push_back(sqlite3_column_int64(statement->get(), 0));
      topics_.push_back({Text(statement->get(), 1), Text(statement->get(), 2)});
    }
    if (state != SQLITE_DONE) return Damaged(path_, database_.get());
    return Ok();
  }

  const std::vector<Ros2Topic>& topics() const override { return topics_; }

  Result<std::unique_ptr<Ros2Cursor>> Read(const std::vector<size_t>& topics) const override {
    std::string ids;
    for (const size_t topic : topics) {
      ids += (ids.empty() ? "" : ",") + std::to_string(topic_ids_[topic]);
    }
    auto statement = Prepare(path_, database_.get(),
                             "SELECT topic_id, timestamp, data FROM messages WHERE topic_id IN (" +
                                 ids + ") ORDER BY timestamp, id");
    if (!statement) return statement.error();
    return std::unique_ptr<Ros2Cursor>(
        std::make_unique<SqliteCursor>(path_, database_, std::move(*statement), topic_ids_));
  }

 private:
  std::string path_;
  Database database_;
  std::vector<Ros2Topic> topics_;
  std::vector<int64_t> topic_ids_;
};

}  // namespace

bool IsRos2Sqlite(const std::string& path) {
  constexpr std::string_view kMagic = "SQLite format 3";
  std::array<char, kMagic.size()> first{};
  std::ifstream in(path, std::ios::binary);
  in.read(first.data(), static_cast<std::streamsize>(first.size()));
  return in && std::string_view(first.data(), first.size()) == kMagic;
}

Result<std::unique_ptr<Ros2Bag>> OpenRos2Sqlite(const std::string& path) {
  sqlite3* opened = nullptr;
  const int state = sqlite3_open_v2(path.c_str(), &opened, SQLITE_OPEN_READONLY, nullptr);
  const Database database(opened, CloseDatabase());
  if (state != SQLITE_OK) return Damaged(path, opened);
  auto bag = std::make_unique<SqliteBag>(path, database);
  if (const Status read = bag->ReadTopics(); !read) return read.error();
  return std::unique_ptr<Ros2Bag>(std::move(bag));
}

}  // namespace tagtwist::internal
