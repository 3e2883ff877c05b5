#include "frontend/io/recordings/ros1/bag_check.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string_view>
#include <utility>
#include <vector>

namespace tagtwist::internal {
namespace {

constexpr std::string_view kMagic = "#ROSBAG V2.0\n";

enum Operation { kMessage = 2, kBagHeader = 3, kIndex = 4, kChunk = 5, kChunkInfo = 6, kLink = 7 };

// A file's bytes, read where they are touched.
class MappedFile {
 public:
  explicit MappedFile(const std::string& path) {
    const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    struct stat status = {};
    if (descriptor < 0) return;
    if (::fstat(descriptor, &status) == 0 && status.st_size > 0) {
      size_ = static_cast<size_t>(status.st_size);
      void* const bytes = ::mmap(nullptr, size_, PROT_READ, MAP_PRIVATE, descriptor, 0);
      if (bytes != MAP_FAILED) bytes_ = static_cast<const char*>(bytes);
    }
    ::close(descriptor);
  }
  ~MappedFile() {
    if (bytes_ != nullptr) ::munmap(const_cast<char*>(bytes_), size_);
  }
  MappedFile(const MappedFile&) = delete;
  MappedFile& operator=(const MappedFile&) = delete;
  std::string_view bytes() const {
    return bytes_ == nullptr ? std::string_view() : std::string_view(bytes_, size_);
  }

 private:
  const char* bytes_ = nullptr;
  size_t size_ = 0;
};

// A number in a record, least byte first; nullopt where it has another size.
std::optional<uint64_t> Number(std::string_view bytes, size_t size) {
  if (bytes.size() != size) return std::nullopt;
  uint64_t value = 0;
  for (size_t i = size; i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

// Takes a length and as many bytes from the front.
std::optional<std::string_view> TakeCounted(std::string_view* rest) {
  const auto length = Number(rest->substr(0, 4), 4);
  if (!length || *length > rest->size() - 4) return std::nullopt;
  const std::string_view out = rest->substr(4, *length);
  rest->remove_prefix(4 + *length);
  return out;
}

using Fields = std::map<std::string_view, std::string_view>;

std::optional<Fields> ParseFields(std::string_view header) {
  Fields out;
  while (!header.empty()) {
    const auto field = TakeCounted(&header);
    const size_t equals = field ? field->find('=') : std::string_view::npos;
    if (equals == std::string_view::npos) return std::nullopt;
    out.emplace(field->substr(0, equals), field->substr(equals + 1));
  }
  return out;
}

struct Record {
  int operation = 0;
  Fields fields;
  std::string_view data;

  std::optional<uint64_t> Get(std::string_view name, size_t size) const {
    const auto found = fields.find(name);
    return found == fields.end() ? std::nullopt : Number(found->second, size);
  }
};

std::optional<Record> TakeRecord(std::string_view* rest) {
  Record out;
  const auto header = TakeCounted(rest);
  const auto fields = header ? ParseFields(*header) : std::nullopt;
  const auto data = fields ? TakeCounted(rest) : std::nullopt;
  if (!data) return std::nullopt;
  out.fields = *fields;
  out.data = *data;
  out.operation = static_cast<int>(out.Get("op", 1).value_or(0));
  return out;
}

class BagCheck {
 public:
  explicit BagCheck(const Limits& limits) : limits_(limits) {}

  // The byte of the record that is at fault; nullopt: none is.
  std::optional<size_t> Fault(std::string_view file) {
    std::string_view rest = file.substr(kMagic.size());
    while (!rest.empty()) {
      const size_t at = file.size() - rest.size();
      const auto record = TakeRecord(&rest);
      if (!record || !IsSound(*record, at)) return at;
    }
    for (const auto& [at, place] : places_) {
      if (chunks_.count(place) == 0) return at;
    }
    const bool ends_early =
        index_place_ != 0 && index_place_ != file.size() && starts_.count(index_place_) == 0;
    if (ends_early) return kMagic.size();
    return std::nullopt;
  }

  // Whether that is for what a chunk would become.
  bool inflates() const { return inflates_; }

 private:
  bool IsSound(const Record& record, size_t at) {
    starts_.insert(at);
    switch (record.operation) {
      case kBagHeader:
        index_place_ = record.Get("index_pos", 8).value_or(1);
        return record.Get("conn_count", 4) && record.Get("chunk_count", 4) && index_place_ != 1;
      case kChunk:
        chunks_.insert(at);
        return IsSoundChunk(record);
      case kIndex:
        return IsSoundIndex(record);
      case kChunkInfo: {
        const auto count = record.Get("count", 4), place = record.Get("chunk_pos", 8);
        if (!count || !place || record.data.size() != 8 * *count) return false;
        places_.emplace_back(at, *place);
        return true;
      }
      case kLink:
        return IsSoundLink(record);
      default:
        return true;
    }
  }

  bool IsSoundLink(const Record& record) {
    const auto number = record.Get("conn", 4);
    const auto fields = ParseFields(record.data);
    if (!number || !fields) return false;
    const auto type = fields->find("type");
    if (type != fields->end()) types_[*number] = std::string(type->second);
    return true;
  }

  bool IsSoundChunk(const Record& record) {
    messages_.clear();
    known_messages_ = false;
    const auto size = record.Get("size", 4);
    const auto compression = record.fields.find("compression");
    if (!size || compression == record.fields.end()) return false;
    if (compression->second != "none") {
      inflates_ = !MayInflate(record.data.size(), *size, limits_);
      return !inflates_;
    }
    known_messages_ = true;
    if (*size != record.data.size()) return false;
    for (std::string_view rest = record.data; !rest.empty();) {
      const size_t at = record.data.size() - rest.size();
      const auto inner = TakeRecord(&rest);
      if (!inner) return false;
      if (inner->operation == kLink && !IsSoundLink(*inner)) return false;
      if (inner->operation == kMessage && !IsSoundMessage(*inner)) return false;
      if (inner->operation == kMessage) messages_.insert(at);
    }
    return true;
  }

  bool IsSoundMessage(const Record& record) const {
    const auto number = record.Get("conn", 4);
    if (!number || !record.Get("time", 8)) return false;
    const auto type = types_.find(*number);
    if (type == types_.end()) return true;
    if (type->second == "sensor_msgs/Image") return IsSoundImage(record.data, false);
    if (type->second == "sensor_msgs/CompressedImage") return IsSoundImage(record.data, true);
    return true;
  }

  // Of the chunk before it: a stamp and an offset for each of its messages on a topic.
  bool IsSoundIndex(const Record& record) const {
    const auto count = record.Get("count", 4);
    if (!count || !record.Get("conn", 4) || record.data.size() != 12 * *count) return false;
    for (size_t i = 0; known_messages_ && i < *count; ++i) {
      const auto offset = Number(record.data.substr(12 * i + 8, 4), 4);
      if (messages_.count(*offset) == 0) return false;
    }
    return true;
  }

  std::set<uint64_t> starts_, chunks_, messages_;    // messages of the last chunk
  bool known_messages_ = false;                      // it was not compressed
  std::vector<std::pair<size_t, uint64_t>> places_;  // of chunks, as others say
  std::map<uint64_t, std::string> types_;
  uint64_t index_place_ = 0;
  Limits limits_;
  bool inflates_ = false;
};

}  // namespace

bool IsSoundImage(std::string_view message, bool compressed) {
  const auto skip = [&](size_t bytes) {
    message.remove_prefix(std::min(bytes, message.size()));
    return true;
  };
  skip(12);  // sequence and stamp
  if (!TakeCounted(&message)) return false;
  if (!compressed) skip(8);  // height and width
  if (!TakeCounted(&message)) return false;
  if (!compressed) skip(5);  // byte order and step
  return TakeCounted(&message).has_value();
}

Status CheckBagRecords(const std::string& path, const Limits& limits) {
  const MappedFile file(path);
  const std::string_view bytes = file.bytes();
  // ROS takes "#ROSBAG V2.00" and the like for the same format.
  if (bytes.substr(0, kMagic.size()) != kMagic) {
    return Error{path +
                 ": expected a ROS bag of format 2.0 (rosbag migrate makes one of an older)"};
  }
  BagCheck check(limits);
  const auto fault = check.Fault(bytes);
  if (!fault) return Ok();
  if (check.inflates()) {
    return Error{path + ": the chunk at byte " + std::to_string(*fault) +
                 " says that it becomes larger than any" + RaisesLimit("inflated_ratio")};
  }
  return Error{path + ": a damaged bag, or one whose recording was not ended: the record at byte " +
               std::to_string(*fault) + " does not add up: rosbag reindex saves what is whole"};
}

}  // namespace tagtwist::internal
