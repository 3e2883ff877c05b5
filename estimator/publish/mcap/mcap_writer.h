#pragma once
#include <boost/crc.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "estimator/publish/foxglove_messages.h"
#include "estimator/publish/mcap/mcap_records.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Messages in JSON as an MCAP file (https://mcap.dev/spec), in chunks of a second or a megabyte
/// with an index, so that readers seek in it. Each message is written at once and stands by itself
/// until its chunk is whole: what a run that is killed has written can be read. Into a pipe,
/// without chunks.
class McapWriter {
 public:
  /// A file that is there is emptied. "x.mcap: cannot write: Permission denied".
  static Result<std::unique_ptr<McapWriter>> Create(const std::string& path,
                                                    const std::vector<FoxgloveChannel>& channels);
  ~McapWriter();
  McapWriter(const McapWriter&) = delete;
  McapWriter& operator=(const McapWriter&) = delete;

  /// After an error nothing more is written.
  Status Write(const FoxgloveMessage& message);
  /// The file's end. Once.
  Status Finish();

 private:
  McapWriter(std::string path, int descriptor, const std::vector<FoxgloveChannel>& channels);
  Status WriteBytes(std::string_view bytes);
  Status Fail();
  void Count(uint64_t t_ns);
  bool IsFull(uint64_t t_ns) const;
  // Makes the messages since the last one a chunk.
  Status EndChunk();

  std::string path_;
  int descriptor_;
  std::vector<FoxgloveChannel> channels_;
  bool in_chunks_;
  McapChunk chunk_;         // that is being filled; without messages: none
  boost::crc_32_type crc_;  // of its messages
  McapCounts counts_;
  std::string chunk_indexes_;
  uint64_t bytes_ = 0;
  bool failed_ = false;
};

}  // namespace tagtwist::internal
