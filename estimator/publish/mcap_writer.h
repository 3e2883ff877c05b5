#pragma once
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "estimator/publish/foxglove_messages.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Messages in JSON as an MCAP file (https://mcap.dev/spec), one record after the other, each
/// written at once: what a run that is killed has written can be read. Without chunks.
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
  McapWriter(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  Status WriteBytes(std::string_view bytes);
  std::string path_;
  int descriptor_;
  std::string set_up_;  // schemas and channels as records
  std::vector<uint64_t> counts_;
  uint64_t bytes_ = 0, first_ns_ = 0, last_ns_ = 0;
  bool failed_ = false;
};

}  // namespace tagtwist::internal
