#pragma once
#include <string>
#include <vector>

namespace tagtwist::internal {

/// What a FileSet that is being put in its place has still to do.
struct CommitPlan {
  std::vector<std::string> put, remove;  // names without a folder
};

/// One line a file: "put states.csv", "remove map.yaml".
std::string FormatCommitPlan(const CommitPlan& plan);
/// Lines that are none, and names with a folder in them, are passed over.
CommitPlan ParseCommitPlan(const std::string& text);

/// The right to put a set in its place: had by at most one process for as long as this lives.
class CommitLock {
 public:
  /// `commit`: the folder that the set is in. It need not be there.
  explicit CommitLock(const std::string& commit);
  ~CommitLock();
  CommitLock(const CommitLock&) = delete;
  CommitLock& operator=(const CommitLock&) = delete;
  bool is_there() const { return descriptor_ >= 0; }
  /// False where somebody else has it.
  bool Take() const;

 private:
  int descriptor_;
};

/// A rename that can be taken back.
struct FileMove {
  std::string from, to;
};

/// 0, or the errno of the move that failed: those before it are taken back then. Asks for no
/// memory.
int MoveAll(const std::vector<FileMove>& moves, size_t* failed) noexcept;

/// Puts a file or folder on the disk, as far as its file system can. 0 or errno.
int FlushToDisk(const std::string& path);

}  // namespace tagtwist::internal
