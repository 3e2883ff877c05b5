#pragma once
#include <memory>
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist {

/// Whether WriteFileSet's folder can be had: it is there and writable, or can be made. Nothing is
/// left behind. "out: cannot write: Permission denied". For asking before long work.
Status CheckOutputFolder(const std::string& folder);

/// Files that appear in a folder together or not at all. They are written into a hidden neighbour
/// first and take their places at Commit(); a set that is not committed leaves no trace. Files of
/// the same name are replaced, other content of the folder is left alone. (Between the renames of a
/// Commit() into a folder that was there already a reader may see old and new files side by side; a
/// rename that fails undoes those before it.)
class FileSet {
 public:
  /// Makes the neighbour; the folder's missing parents are made, too.
  static Result<std::unique_ptr<FileSet>> Begin(const std::string& folder);
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// A file of the set; `name` has no folder in it.
  Status Add(const std::string& name, const std::string& content);

  /// `obsolete`: files of earlier sets that are to go if this set does not have them.
  Status Commit(const std::vector<std::string>& obsolete = {});

 private:
  explicit FileSet(std::string folder);
  Status CommitIntoFolder(const std::vector<std::string>& obsolete);

  std::string folder_, partial_;
  bool folder_existed_ = false, committed_ = false;
  std::vector<std::string> made_parents_;  // outermost first
  std::vector<std::string> names_;
};

}  // namespace tagtwist
