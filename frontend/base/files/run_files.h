#pragma once
#include <sys/types.h>

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Files that take their places in a folder together.
struct OutputSet {
  std::string folder;
  std::vector<std::string> written;   // names that this run may write
  std::vector<std::string> obsolete;  // names of older runs that go where this run lacks them
  std::vector<std::string> marks;     // names that every older run has left there
};

/// What a run reads, against what it writes: inputs are never outputs. Files are told apart by
/// device and inode, so a link is the file that it leads to. Devices and pipes may be both.
class RunFiles {
 public:
  /// A file that is read; `flag` is how it was given: "--config". An empty path is none.
  void Reads(const std::string& flag, const std::string& path);
  /// A recording: a file, or a folder, of which all that lies below it counts as read.
  void ReadsRecording(const std::string& flag, const std::string& path);

  /// A file that is to be written, whole or row by row. Refused where it is read, or written
  /// already for another flag: "a.tum: --json would overwrite it, but it is read as ...".
  Status Writes(const std::string& flag, const std::string& path);
  /// The same for standard output, where it leads to a file: refused where that is read by itself.
  Status WritesStandardOutput();
  /// The same for the files of a set. Within a recording only what an older run has left is
  /// replaced. Returns the obsolete names that must stay: those that are read, and all of them
  /// where the folder lacks an older run's marks.
  Result<std::vector<std::string>> WritesSet(const std::string& flag, const OutputSet& set);

 private:
  using FileId = std::pair<dev_t, ino_t>;
  // "--dataset rec"; nullopt: not read.
  std::optional<std::string> ReaderOf(const std::string& path) const;
  std::optional<std::string> RecordingOf(const std::string& path);
  void Walk(const std::string& folder, const std::string& reader);

  std::map<FileId, std::string> read_;          // by themselves; to how they were given
  std::map<FileId, std::string> in_recording_;  // filled when it is first asked for
  std::vector<std::pair<std::string, std::string>> unseen_folders_;  // folder, how it was given
  std::map<std::string, std::string> written_;                       // place, flag
};

}  // namespace tagtwist::internal
