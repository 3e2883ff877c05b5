#pragma once
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "frontend/base/files/file_set_commit.h"
#include "frontend/base/files/growing_file.h"
#include "frontend/base/files/partial.h"
#include "frontend/base/result.h"

namespace tagtwist::internal {

/// Whether WriteFileSet's folder can be had: it is there and writable, or can be made. Nothing is
/// left behind. "out: cannot write: Permission denied". For asking before long work.
Status CheckOutputFolder(const std::string& folder);

/// What FileSets of processes that were ended have left in a folder, and beside it: a set that was
/// being put in its place is finished, one that was not whole is removed. Returns what was done, a
/// line each: "res/.results.partial-12: left by a run that was ended: removed".
Result<std::vector<std::string>> RecoverFileSet(const std::string& folder);

/// False while a set is being put in its place there, and where that was cut short.
bool IsFileSetWhole(const std::string& folder);

/// Files that appear in a folder together or not at all. They are written into a hidden neighbour
/// first and take their places at Commit(); a set that is not committed leaves no trace. Files of
/// the same name are replaced, other content of the folder is left alone. A Commit() into a folder
/// that was there already is one rename, of the set to a name that says that it counts; the renames
/// of its files follow. Where they are cut short RecoverFileSet finishes them, and so does the next
/// Commit(); one that fails undoes those before it. From the first of these renames to the last
/// no memory is asked for, nor to put away what they replaced: where it ends, it ends before them
/// or after them.
class FileSet {
 public:
  /// Makes the neighbour; the folder's missing parents are made, too.
  static Result<std::unique_ptr<FileSet>> Begin(const std::string& folder);
  ~FileSet();
  FileSet(const FileSet&) = delete;
  FileSet& operator=(const FileSet&) = delete;

  /// A file of the set; `name` has no folder in it.
  Status Add(const std::string& name, const std::string& content);
  /// The next piece of a file that is not added whole; the first makes it.
  Status Append(const std::string& name, std::string_view piece);

  /// `obsolete`: files of earlier sets that are to go if this set does not have them.
  Status Commit(const std::vector<std::string>& obsolete = {});

 private:
  FileSet(std::string folder, bool folder_existed, Partial partial);
  Status CommitIntoFolder(const std::vector<std::string>& obsolete);
  Status ToldByItsPlace(const std::string& name, const Status& written) const;
  Result<std::vector<std::string>> Leaving(const std::vector<std::string>& obsolete) const;
  std::vector<FileMove> MovesOf(const std::string& commit,
                                const std::vector<std::string>& leaving) const;

  std::string folder_;
  bool folder_existed_ = false;
  Partial partial_;
  std::vector<std::string> made_parents_;  // outermost first
  std::vector<std::string> names_;
  std::map<std::string, GrowingFile> growing_;
  bool committed_ = false;
};

}  // namespace tagtwist::internal
