// MCAP: https://mcap.dev/spec, version 0.
#include <algorithm>
#include <array>
#include <cstring>
#include <fstream>
#include <map>
#include <string_view>
#include <utility>

#include "frontend/io/recordings/ros2/mcap_bytes.h"
#include "frontend/io/recordings/ros2/ros2_bag.h"

namespace tagtwist::internal {
namespace {

constexpr std::array<uint8_t, 8> kMagic = {0x89, 'M', 'C', 'A', 'P', '0', '\r', '\n'};
constexpr size_t kRecordHead = 9;  // opcode and length
enum Opcode : uint8_t { kSchema = 0x03, kChannel = 0x04, kMessage = 0x05, kChunk = 0x06 };

// Where a message lies: in the file, or in the unpacked chunk at that place of the file.
struct MessagePlace {
  size_t topic = 0;
  int64_t arrival_ns = 0;
  uint64_t file_offset = 0, chunk_offset = 0;  // of the record's content
  uint64_t size = 0;                           // of the record's content
  bool in_chunk = false;
};

Error DamagedMcap(const std::string& path) {
  return Error{path + ": a damaged MCAP file: mcap recover saves what is whole"};
}

constexpr size_t kMessageHead = 22;  // channel, sequence and two times

class File {
 public:
  File(const std::string& path, const Limits& limits)
      : in_(path, std::ios::binary), most_(static_cast<uint64_t>(limits.record_bytes)) {
    in_.seekg(0, std::ios::end);
    size_ = in_ ? static_cast<uint64_t>(in_.tellg()) : 0;
  }
  uint64_t size() const { return size_; }
  std::optional<std::string> Read(uint64_t offset, uint64_t size) {
    if (offset > size_ || size > size_ - offset || size > most_) return std::nullopt;
    std::string out(size, '\0');
    in_.clear();
    in_.seekg(static_cast<std::streamoff>(offset));
    in_.read(out.data(), static_cast<std::streamsize>(size));
    return in_ ? std::optional(std::move(out)) : std::nullopt;
  }

 private:
  std::ifstream in_;
  uint64_t size_ = 0, most_;
};

class McapCursor : public Ros2Cursor {
 public:
  McapCursor(const std::string& path, std::vector<MessagePlace> places, const Limits& limits)
      : path_(path), limits_(limits), file_(path, limits), places_(std::move(places)) {}

  Result<std::optional<Ros2Message>> Next() override {
    if (next_ == places_.size()) return std::optional<Ros2Message>();
    const MessagePlace& place = places_[next_++];
    std::string_view content;
    std::optional<std::string> own;
    if (place.in_chunk) {
      if (const Status loaded = Load(place.file_offset); !loaded) return loaded.error();
      content = std::string_view(chunk_).substr(place.chunk_offset, place.size);
    } else {
      own = file_.Read(place.file_offset, place.size);
      if (!own) return DamagedMcap(path_);
      content = *own;
    }
    content.remove_prefix(kMessageHead);
    return std::optional<Ros2Message>(
        Ros2Message{place.topic, place.arrival_ns, {content.begin(), content.end()}});
  }

 private:
  Status Load(uint64_t offset) {
    if (offset == loaded_) return Ok();
    const auto head = file_.Read(offset - 8, 8);
    const auto packed = head ? file_.Read(offset, McapBytes(*head).Take<uint64_t>()) : std::nullopt;
    if (!packed) return DamagedMcap(path_);
    auto chunk = UnpackMcapChunk(*packed, limits_);
    if (!chunk) return Error{path_ + ": " + chunk.error().message};
    chunk_ = std::move(*chunk);
    loaded_ = offset;
    return Ok();
  }

  std::string path_;
  Limits limits_;
  File file_;
  std::vector<MessagePlace> places_;
  size_t next_ = 0;
  uint64_t loaded_ = 0;  // offset of the chunk's content; 0: none
  std::string chunk_;
};

class McapBag : public Ros2Bag {
 public:
  McapBag(std::string path, const Limits& limits) : path_(std::move(path)), limits_(limits) {}

  Status Scan() {
    File file(path_, limits_);
    const uint64_t end = file.size();
    const auto first = file.Read(0, kMagic.size());
    const auto last = end < 2 * kMagic.size() ? std::nullopt : file.Read(end - kMagic.size(), 8);
    if (!first || !last || !IsMagic(*first)) return DamagedMcap(path_);
    if (!IsMagic(*last)) {
      return Error{path_ + ": an MCAP file that is cut or was not ended: mcap recover saves what " +
                   "is there"};
    }
    uint64_t offset = kMagic.size();
    while (offset < end - kMagic.size()) {
      const auto head = file.Read(offset, kRecordHead);
      if (!head) return DamagedMcap(path_);
      McapBytes bytes(*head);
      const auto opcode = bytes.Take<uint8_t>();
      const auto size = bytes.Take<uint64_t>();
      offset += kRecordHead;
      if (size > end - kMagic.size() - offset) return DamagedMcap(path_);
      if (opcode >= kSchema && opcode <= kChunk) {
        const auto content = file.Read(offset, size);
        if (!content) return DamagedMcap(path_);
        if (const Status taken = Take(opcode, *content, offset, {}); !taken) return taken;
      }
      offset += size;
    }
    std::stable_sort(places_.begin(), places_.end(),
                     [](const auto& a, const auto& b) { return a.arrival_ns < b.arrival_ns; });
    return Ok();
  }

  const std::vector<Ros2Topic>& topics() const override { return topics_; }

  Result<std::unique_ptr<Ros2Cursor>> Read(const std::vector<size_t>& topics) const override {
    std::vector<MessagePlace> places;
    for (const MessagePlace& place : places_) {
      if (std::find(topics.begin(), topics.end(), place.topic) != topics.end()) {
        places.push_back(place);
      }
    }
    return std::unique_ptr<Ros2Cursor>(
        std::make_unique<McapCursor>(path_, std::move(places), limits_));
  }

 private:
  static bool IsMagic(const std::string& bytes) {
    return bytes.size() == kMagic.size() &&
           std::memcmp(bytes.data(), kMagic.data(), kMagic.size()) == 0;
  }

  // A record; `chunk`: offset of the content of the chunk that it lies in, and its own in there.
  struct InChunk {
    uint64_t file_offset = 0, chunk_offset = 0;
  };
  Status Take(uint8_t opcode, std::string_view content, uint64_t offset,
              std::optional<InChunk> in_chunk) {
    McapBytes bytes(content);
    if (opcode == kChunk && !in_chunk) return TakeChunk(content, offset);
    if (opcode == kSchema) {
      const auto id = bytes.Take<uint16_t>();
      schemas_[id] = bytes.TakeText();
    } else if (opcode == kChannel) {
      const auto id = bytes.Take<uint16_t>();
      const auto schema = bytes.Take<uint16_t>();
      const std::string name(bytes.TakeText());
      const std::string_view encoding = bytes.TakeText();
      if (encoding == "cdr" && channels_.count(id) == 0) channels_[id] = TopicOf(name, schema);
    } else if (opcode == kMessage) {
      const auto channel = channels_.find(bytes.Take<uint16_t>());
      bytes.Take<uint32_t>();
      const auto arrival_ns = static_cast<int64_t>(bytes.Take<uint64_t>());
      bytes.Take<uint64_t>();
      if (bytes.Good() && channel != channels_.end()) {
        MessagePlace place{channel->second, arrival_ns, offset, 0, content.size(), false};
        if (in_chunk) {
          place.file_offset = in_chunk->file_offset;
          place.chunk_offset = in_chunk->chunk_offset;
          place.in_chunk = true;
        }
        places_.push_back(place);
      }
    }
    return bytes.Good() ? Ok() : Status(DamagedMcap(path_));
  }

  Status TakeChunk(std::string_view content, uint64_t offset) {
    const auto records = UnpackMcapChunk(content, limits_);
    if (!records) return Error{path_ + ": " + records.error().message};
    McapBytes bytes(*records);
    while (bytes.left() > 0) {
      const auto opcode = bytes.Take<uint8_t>();
      const auto size = bytes.Take<uint64_t>();
      const uint64_t inner = records->size() - bytes.left();
      const std::string_view record = bytes.Take(size);
      if (!bytes.Good()) return Error{path_ + ": a damaged chunk"};
      const Status taken = Take(opcode, record, 0, InChunk{offset, inner});
      if (!taken) return taken;
    }
    return Ok();
  }

  // Several channels may carry one topic.
  size_t TopicOf(const std::string& name, uint16_t schema) {
    for (size_t i = 0; i < topics_.size(); ++i) {
      if (topics_[i].name == name) return i;
    }
    topics_.push_back({name, schemas_[schema]});
    return topics_.size() - 1;
  }

  std::string path_;
  Limits limits_;
  std::map<uint16_t, std::string> schemas_;  // names by id
  std::map<uint16_t, size_t> channels_;      // topics by id
  std::vector<Ros2Topic> topics_;
  std::vector<MessagePlace> places_;
};

}  // namespace

bool IsRos2Mcap(const std::string& path) {
  std::array<char, kMagic.size()> first{};
  std::ifstream in(path, std::ios::binary);
  in.read(first.data(), static_cast<std::streamsize>(first.size()));
  return in && std::memcmp(first.data(), kMagic.data(), kMagic.size()) == 0;
}

Result<std::unique_ptr<Ros2Bag>> OpenRos2Mcap(const std::string& path, const Limits& limits) {
  auto bag = std::make_unique<McapBag>(path, limits);
  if (const Status scanned = bag->Scan(); !scanned) return scanned.error();
  return std::unique_ptr<Ros2Bag>(std::move(bag));
}

}  // namespace tagtwist::internal
