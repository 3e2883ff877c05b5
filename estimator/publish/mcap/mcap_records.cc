#include "estimator/publish/mcap/mcap_records.h"

#include <algorithm>
#include <numeric>

namespace tagtwist::internal {
namespace {

enum Opcode : uint8_t {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kChunk = 6,
  kMessageIndex = 7,
  kChunkIndex = 8,
  kStatistics = 11,
  kSummaryOffset = 14,
  kDataEnd = 15,
  kOfOurOwn = 0x80  // readers pass over it
};

constexpr size_t kRecordHead = 9;  // opcode and length

class Fields {
 public:
  template <typename Number>
  Fields& Put(Number value) {
    for (size_t i = 0; i < sizeof(Number); ++i) {
      bytes_ += static_cast<char>((static_cast<uint64_t>(value) >> (8 * i)) & 0xff);
    }
    return *this;
  }
  Fields& Text(std::string_view text) {
    Put(static_cast<uint32_t>(text.size()));
    return Bytes(text);
  }
  Fields& Bytes(std::string_view bytes) {
    bytes_ += bytes;
    return *this;
  }
  const std::string& bytes() const { return bytes_; }
  std::string Record(Opcode opcode) const {
    Fields head;
    head.Put(static_cast<uint8_t>(opcode)).Put(static_cast<uint64_t>(bytes_.size()));
    return head.bytes_ + bytes_;
  }

 private:
  std::string bytes_;
};

std::string MessageIndex(uint16_t channel,
                         const std::vector<std::pair<uint64_t, uint64_t>>& messages) {
  Fields places;
  for (const auto& [t_ns, place] : messages) places.Put(t_ns).Put(place);
  return Fields().Put(channel).Text(places.bytes()).Record(kMessageIndex);
}

std::string Statistics(const McapCounts& counts) {
  Fields by_channel;
  for (size_t i = 0; i < counts.messages.size(); ++i) {
    by_channel.Put(static_cast<uint16_t>(i + 1)).Put(counts.messages[i]);
  }
  return Fields()
      .Put(std::accumulate(counts.messages.begin(), counts.messages.end(), uint64_t{0}))
      .Put(static_cast<uint16_t>(counts.messages.size()))  // schemas
      .Put(static_cast<uint32_t>(counts.messages.size()))  // channels
      .Put(uint32_t{0})                                    // attachments
      .Put(uint32_t{0})                                    // metadata
      .Put(counts.chunks)
      .Put(counts.first_ns)
      .Put(counts.last_ns)
      .Text(by_channel.bytes())
      .Record(kStatistics);
}

}  // namespace

std::string McapHeader() { return Fields().Text("").Text("tagtwist").Record(kHeader); }

std::string McapSchemas(const std::vector<FoxgloveChannel>& channels) {
  std::string out;
  for (const FoxgloveChannel& channel : channels) {
    out += Fields()
               .Put(static_cast<uint16_t>(channel.id))
               .Text(channel.schema_name)
               .Text("jsonschema")
               .Text(channel.schema)
               .Record(kSchema);
  }
  return out;
}

std::string McapChannels(const std::vector<FoxgloveChannel>& channels) {
  std::string out;
  for (const FoxgloveChannel& channel : channels) {
    out += Fields()
               .Put(static_cast<uint16_t>(channel.id))
               .Put(static_cast<uint16_t>(channel.id))  // its schema
               .Text(channel.topic)
               .Text("json")
               .Put(uint32_t{0})  // no metadata
               .Record(kChannel);
  }
  return out;
}

std::string McapMessage(const FoxgloveMessage& message, uint32_t sequence) {
  const auto t_ns = static_cast<uint64_t>(std::max<int64_t>(message.t_ns, 0));
  return Fields()
      .Put(static_cast<uint16_t>(message.channel))
      .Put(sequence)
      .Put(t_ns)  // logged
      .Put(t_ns)  // published
      .Bytes(message.json)
      .Record(kMessage);
}

std::string McapDataEnd() { return Fields().Put(uint32_t{0}).Record(kDataEnd); }

// The record's length counts the messages, which are elsewhere.
std::string McapChunkHead(const McapChunk& chunk) {
  const std::string fields = Fields()
                                 .Put(chunk.first_ns)
                                 .Put(chunk.last_ns)
                                 .Put(chunk.size)
                                 .Put(chunk.crc)
                                 .Text("")  // not compressed
                                 .Put(chunk.size)
                                 .bytes();
  return Fields()
             .Put(static_cast<uint8_t>(kChunk))
             .Put(static_cast<uint64_t>(fields.size()) + chunk.size)
             .bytes() +
         fields;
}

std::string McapOpenHead() {
  return Fields()
      .Bytes(std::string(McapChunkHead({}).size() - kRecordHead, '\0'))
      .Record(kOfOurOwn);
}

std::string McapMessageIndexes(const McapChunk& chunk) {
  std::string out;
  for (const auto& [channel, messages] : chunk.messages) out += MessageIndex(channel, messages);
  return out;
}

std::string McapChunkIndex(const McapChunk& chunk) {
  const uint64_t length = McapChunkHead(chunk).size() + chunk.size;
  Fields places;
  uint64_t at = chunk.start + length;
  const uint64_t behind = at;
  for (const auto& [channel, messages] : chunk.messages) {
    places.Put(channel).Put(at);
    at += MessageIndex(channel, messages).size();
  }
  return Fields()
      .Put(chunk.first_ns)
      .Put(chunk.last_ns)
      .Put(chunk.start)
      .Put(length)
      .Text(places.bytes())
      .Put(at - behind)
      .Text("")
      .Put(chunk.size)
      .Put(chunk.size)
      .Record(kChunkIndex);
}

std::string McapSummary(uint64_t start, const std::vector<FoxgloveChannel>& channels,
                        const McapCounts& counts, const std::string& chunk_indexes) {
  std::string out, offsets;  // records by kind, and where each kind is
  const auto add = [&](Opcode opcode, const std::string& records) {
    if (records.empty()) return;
    offsets += Fields()
                   .Put(static_cast<uint8_t>(opcode))
                   .Put(start + out.size())
                   .Put(static_cast<uint64_t>(records.size()))
                   .Record(kSummaryOffset);
    out += records;
  };
  add(kSchema, McapSchemas(channels));
  add(kChannel, McapChannels(channels));
  add(kStatistics, Statistics(counts));
  add(kChunkIndex, chunk_indexes);
  const uint64_t offsets_start = start + out.size();
  return out + offsets + Fields().Put(start).Put(offsets_start).Put(uint32_t{0}).Record(kFooter);
}

}  // namespace tagtwist::internal
