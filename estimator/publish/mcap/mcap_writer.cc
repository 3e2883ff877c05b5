#include "estimator/publish/mcap/mcap_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace tagtwist::internal {
namespace {

constexpr uint64_t kMostChunkNs = 1'000'000'000;
constexpr uint64_t kMostChunkBytes = 1 << 20;

}  // namespace

McapWriter::McapWriter(std::string path, int descriptor,
                       const std::vector<FoxgloveChannel>& channels)
    : path_(std::move(path)),
      descriptor_(descriptor),
      channels_(channels),
      in_chunks_(::lseek(descriptor, 0, SEEK_CUR) >= 0) {
  counts_.messages.resize(channels.size());
}

Result<std::unique_ptr<McapWriter>> McapWriter::Create(
    const std::string& path, const std::vector<FoxgloveChannel>& channels) {
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  if (descriptor < 0) {
    return Error{path + ": cannot write: " + std::generic_category().message(errno)};
  }
  std::unique_ptr<McapWriter> out(new McapWriter(path, descriptor, channels));
  const Status written = out->WriteBytes(std::string(kMcapMagic) + McapHeader() +
                                         McapSchemas(channels) + McapChannels(channels));
  if (!written) return written.error();
  return out;
}

McapWriter::~McapWriter() { ::close(descriptor_); }

Status McapWriter::Fail() {
  failed_ = true;
  return Error{path_ + ": cannot write: " + std::generic_category().message(errno)};
}

Status McapWriter::WriteBytes(std::string_view bytes) {
  while (!failed_ && !bytes.empty()) {
    const ssize_t written = ::write(descriptor_, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written < 0) return Fail();
    bytes_ += static_cast<uint64_t>(written);
    bytes.remove_prefix(static_cast<size_t>(written));
  }
  return Ok();
}

void McapWriter::Count(uint64_t t_ns) {
  const bool is_first = std::all_of(counts_.messages.begin(), counts_.messages.end(),
                                    [](uint64_t n) { return n == 0; });
  counts_.first_ns = is_first ? t_ns : std::min(counts_.first_ns, t_ns);
  counts_.last_ns = std::max(counts_.last_ns, t_ns);
}

bool McapWriter::IsFull(uint64_t t_ns) const {
  return chunk_.size >= kMostChunkBytes || t_ns >= chunk_.first_ns + kMostChunkNs;
}

Status McapWriter::Write(const FoxgloveMessage& message) {
  const auto t_ns = static_cast<uint64_t>(std::max<int64_t>(message.t_ns, 0));
  Count(t_ns);
  uint64_t& count = counts_.messages[message.channel - 1];
  const std::string record = McapMessage(message, static_cast<uint32_t>(count++));
  if (!in_chunks_) return WriteBytes(record);
  if (!chunk_.messages.empty() && IsFull(t_ns)) {
    if (const Status ended = EndChunk(); !ended) return ended;
  }
  const bool begins = chunk_.messages.empty();
  if (begins) {
    chunk_.start = bytes_;
    chunk_.first_ns = chunk_.last_ns = t_ns;
  }
  chunk_.messages[static_cast<uint16_t>(message.channel)].emplace_back(t_ns, chunk_.size);
  chunk_.first_ns = std::min(chunk_.first_ns, t_ns);
  chunk_.last_ns = std::max(chunk_.last_ns, t_ns);
  chunk_.size += record.size();
  crc_.process_bytes(record.data(), record.size());
  return WriteBytes(begins ? McapOpenHead() + record : record);
}

Status McapWriter::EndChunk() {
  if (failed_ || chunk_.messages.empty()) return Ok();
  chunk_.crc = crc_.checksum();
  const std::string head = McapChunkHead(chunk_);
  const ssize_t written =
      ::pwrite(descriptor_, head.data(), head.size(), static_cast<off_t>(chunk_.start));
  if (written != static_cast<ssize_t>(head.size())) return Fail();
  chunk_indexes_ += McapChunkIndex(chunk_);
  ++counts_.chunks;
  const std::string indexes = McapMessageIndexes(chunk_);
  chunk_ = {};
  crc_.reset();
  return WriteBytes(indexes);
}

Status McapWriter::Finish() {
  if (const Status ended = EndChunk(); !ended) return ended;
  const std::string end = McapDataEnd();
  return WriteBytes(end + McapSummary(bytes_ + end.size(), channels_, counts_, chunk_indexes_) +
                    std::string(kMcapMagic));
}

}  // namespace tagtwist::internal
