#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "estimator/publish/foxglove_messages.h"

namespace tagtwist::internal {

/// Records of MCAP files as bytes (https://mcap.dev/spec): an opcode, a length of 8 bytes, fields;
/// numbers are little-endian.
inline constexpr std::string_view kMcapMagic("\x89MCAP0\r\n", 8);

std::string McapHeader();
/// A schema for each, of the channel's id.
std::string McapSchemas(const std::vector<FoxgloveChannel>& channels);
std::string McapChannels(const std::vector<FoxgloveChannel>& channels);
std::string McapMessage(const FoxgloveMessage& message, uint32_t sequence);
std::string McapDataEnd();

/// Messages that stand together in a file.
struct McapChunk {
  uint64_t start = 0;  // of its record [byte of the file]
  uint64_t size = 0;   // of its messages' records [bytes]
  uint32_t crc = 0;    // of them, CRC-32
  uint64_t first_ns = 0, last_ns = 0;
  std::map<uint16_t, std::vector<std::pair<uint64_t, uint64_t>>>
      messages;  // time, place; by channel
};

/// What stands before a chunk's messages: those that follow are the chunk's.
std::string McapChunkHead(const McapChunk& chunk);
/// As long, of a kind that readers pass over: the messages that follow stand by themselves.
std::string McapOpenHead();
/// Where in the chunk each message is, a record a channel: they stand behind it.
std::string McapMessageIndexes(const McapChunk& chunk);
/// Of the file's end: where the chunk and its indexes are.
std::string McapChunkIndex(const McapChunk& chunk);

struct McapCounts {
  std::vector<uint64_t> messages;  // by channel, from 1 on
  uint32_t chunks = 0;
  uint64_t first_ns = 0, last_ns = 0;
};
/// The file's end, but for the magic: it begins at byte `start`.
std::string McapSummary(uint64_t start, const std::vector<FoxgloveChannel>& channels,
                        const McapCounts& counts, const std::string& chunk_indexes);

}  // namespace tagtwist::internal
