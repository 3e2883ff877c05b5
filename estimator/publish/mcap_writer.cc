#include "estimator/publish/mcap_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <numeric>
#include <system_error>

namespace tagtwist::internal {
namespace {

constexpr std::string_view kMagic("\x89MCAP0\r\n", 8);
enum Opcode : char {
  kHeader = 1,
  kFooter = 2,
  kSchema = 3,
  kChannel = 4,
  kMessage = 5,
  kStatistics = 11,
  kDataEnd = 15
};

// The fields of a record, little-endian.
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
  std::string Record(Opcode opcode) const {
    Fields head;
    head.Put(static_cast<uint8_t>(opcode)).Put(static_cast<uint64_t>(bytes_.size()));
    return head.bytes_ + bytes_;
  }

 private:
  std::string bytes_;
};

std::string SetUpRecords(const std::vector<FoxgloveChannel>& channels) {
  std::string out;
  for (size_t i = 0; i < channels.size(); ++i) {
    const FoxgloveChannel& channel = channels[i];
    const auto schema = static_cast<uint16_t>(i + 1);  // 0 would be none
    out += Fields()
               .Put(schema)
               .Text(channel.schema_name)
               .Text("jsonschema")
               .Text(channel.schema)
               .Record(kSchema);
    out += Fields()
               .Put(static_cast<uint16_t>(channel.id))
               .Put(schema)
               .Text(channel.topic)
               .Text("json")
               .Put(uint32_t{0})  // no metadata
               .Record(kChannel);
  }
  return out;
}

}  // namespace

Result<std::unique_ptr<McapWriter>> McapWriter::Create(
    const std::string& path, const std::vector<FoxgloveChannel>& channels) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return Error{path + ": cannot write: " + std::generic_category().message(errno)};
  }
  std::unique_ptr<McapWriter> out(new McapWriter(path, descriptor));
  out->set_up_ = SetUpRecords(channels);
  out->counts_.resize(channels.size());
  const std::string head = Fields().Text("").Text("tagtwist").Record(kHeader);
  const Status written = out->WriteBytes(std::string(kMagic) + head + out->set_up_);
  if (!written) return written.error();
  return out;
}

McapWriter::~McapWriter() { ::close(descriptor_); }

Status McapWriter::WriteBytes(std::string_view bytes) {
  while (!failed_ && !bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) {
      failed_ = true;
      return Error{path_ + ": cannot write: " + std::generic_category().message(errno)};
    }
    bytes_ += static_cast<uint64_t>(written);
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return Ok();
}

Status McapWriter::Write(const FoxgloveMessage& message) {
  const auto t_ns = static_cast<uint64_t>(std::max<int64_t>(message.t_ns, 0));
  uint64_t& count = counts_[message.channel - 1];
  const bool is_first = std::all_of(counts_.begin(), counts_.end(), [](auto n) { return n == 0; });
  first_ns_ = is_first ? t_ns : std::min(first_ns_, t_ns);
  last_ns_ = std::max(last_ns_, t_ns);
  return WriteBytes(Fields()
                        .Put(static_cast<uint16_t>(message.channel))
                        .Put(static_cast<uint32_t>(count++))
                        .Put(t_ns)  // logged
                        .Put(t_ns)  // published
                        .Bytes(message.json)
                        .Record(kMessage));
}

Status McapWriter::Finish() {
  if (const Status ended = WriteBytes(Fields().Put(uint32_t{0}).Record(kDataEnd)); !ended) {
    return ended;
  }
  const uint64_t summary = bytes_;
  Fields counts, statistics;
  for (size_t i = 0; i < counts_.size(); ++i) {
    counts.Put(static_cast<uint16_t>(i + 1)).Put(counts_[i]);
  }
  const std::string by_channel = counts.Record(kStatistics).substr(9);
  statistics.Put(std::accumulate(counts_.begin(), counts_.end(), uint64_t{0}))
      .Put(static_cast<uint16_t>(counts_.size()))  // schemas
      .Put(static_cast<uint32_t>(counts_.size()))  // channels
      .Put(uint32_t{0})                            // attachments
      .Put(uint32_t{0})                            // metadata
      .Put(uint32_t{0})                            // chunks
      .Put(first_ns_)
      .Put(last_ns_)
      .Text(by_channel);
  const std::string footer =
      Fields().Put(summary).Put(uint64_t{0}).Put(uint32_t{0}).Record(kFooter);
  return WriteBytes(set_up_ + statistics.Record(kStatistics) + footer + std::string(kMagic));
}

}  // namespace tagtwist::internal
