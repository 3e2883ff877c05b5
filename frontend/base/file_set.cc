#include "frontend/base/file_set.h"

#include <algorithm>
#include <filesystem>
#include <system_error>
#include <utility>

#include "frontend/base/atomic_file.h"

namespace tagtwist {
namespace {

namespace fs = std::filesystem;

Error CannotWrite(const std::string& path, const std::error_code& reason) {
  return Error{path + ": cannot write: " + reason.message()};
}

std::string WithoutTrailingSlash(const std::string& folder) {
  fs::path path = fs::path(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.empty() ? "." : path.string();
}

// Folders that must be made for `folder` to be there, outermost first.
std::vector<std::string> MissingFolders(const std::string& folder) {
  std::vector<std::string> missing;
  std::error_code ignored;
  for (fs::path p = folder; !p.empty() && !fs::exists(p, ignored); p = p.parent_path()) {
    missing.insert(missing.begin(), p.string());
  }
  return missing;
}

void RemoveFolders(const std::vector<std::string>& outermost_first) {
  std::error_code ignored;
  for (auto it = outermost_first.rbegin(); it != outermost_first.rend(); ++it) {
    fs::remove(*it, ignored);  // only while they are empty
  }
}

// Makes the folders; those that were made are gone again after an error.
Status MakeFolders(const std::vector<std::string>& outermost_first) {
  for (size_t i = 0; i < outermost_first.size(); ++i) {
    std::error_code failure;
    fs::create_directory(outermost_first[i], failure);
    if (!failure) continue;
    RemoveFolders({outermost_first.begin(), outermost_first.begin() + static_cast<long>(i)});
    return CannotWrite(outermost_first[i], failure);
  }
  return Ok();
}

// A rename that can be taken back.
struct Move {
  fs::path from, to;
};

void Undo(const std::vector<Move>& moves) {
  std::error_code ignored;
  for (auto it = moves.rbegin(); it != moves.rend(); ++it) fs::rename(it->to, it->from, ignored);
}

}  // namespace

Status CheckOutputFolder(const std::string& folder) {
  const std::string path = WithoutTrailingSlash(folder);
  std::error_code ignored;
  if (fs::exists(path, ignored) && !fs::is_directory(path, ignored)) {
    return Error{folder + ": cannot write: is a file, expected a folder"};
  }
  const std::vector<std::string> missing = MissingFolders(path);
  if (auto made = MakeFolders(missing); !made) return made;
  const std::string probe = PartialNeighbour(path + "/probe");
  std::error_code failure;
  fs::create_directory(probe, failure);
  fs::remove(probe, ignored);
  RemoveFolders(missing);
  if (failure) return CannotWrite(folder, failure);
  return Ok();
}

FileSet::FileSet(std::string folder) : folder_(std::move(folder)) {}

Result<std::unique_ptr<FileSet>> FileSet::Begin(const std::string& folder) {
  if (auto possible = CheckOutputFolder(folder); !possible) return possible.error();
  std::unique_ptr<FileSet> set(new FileSet(WithoutTrailingSlash(folder)));
  std::error_code ignored;
  set->folder_existed_ = fs::exists(set->folder_, ignored);
  if (!set->folder_existed_) {
    std::vector<std::string> missing = MissingFolders(set->folder_);
    missing.pop_back();  // the folder itself appears at Commit
    if (auto made = MakeFolders(missing); !made) return made.error();
    set->made_parents_ = std::move(missing);
  }
  set->partial_ = PartialNeighbour(set->folder_existed_ ? set->folder_ + "/results" : set->folder_);
  if (auto made = MakeFolders({set->partial_}); !made) {
    RemoveFolders(set->made_parents_);
    return made.error();
  }
  return set;
}

FileSet::~FileSet() {
  std::error_code ignored;
  fs::remove_all(partial_, ignored);
  if (!committed_) RemoveFolders(made_parents_);
}

Status FileSet::Add(const std::string& name, const std::string& content) {
  const std::string target = partial_ + "/" + name;
  if (const auto written = WriteFileAtomically(target, content); !written) {
    // The partial folder is ours alone to know of: name the file by where it would have been.
    return Error{folder_ + "/" + name + written.error().message.substr(target.size())};
  }
  names_.push_back(name);
  return Ok();
}

Status FileSet::Commit(const std::vector<std::string>& obsolete) {
  if (folder_existed_) return CommitIntoFolder(obsolete);
  std::error_code failure;
  fs::rename(partial_, folder_, failure);
  if (failure) return CannotWrite(folder_, failure);
  committed_ = true;
  return Ok();
}

Status FileSet::CommitIntoFolder(const std::vector<std::string>& obsolete) {
  const fs::path old = fs::path(partial_) / ".replaced";
  if (auto made = MakeFolders({old.string()}); !made) return made;
  std::vector<std::string> leaving = names_;
  for (const std::string& name : obsolete) {
    if (std::find(names_.begin(), names_.end(), name) == names_.end()) leaving.push_back(name);
  }
  std::vector<Move> planned, done;
  for (const std::string& name : leaving) {
    const fs::path target = fs::path(folder_) / name;
    const fs::file_status status = fs::symlink_status(target);
    if (fs::is_directory(status)) {
      return Error{target.string() + ": cannot write: is a folder, expected a file"};
    }
    if (fs::exists(status)) planned.push_back({target, old / name});
  }
  for (const std::string& name : names_) {
    planned.push_back({fs::path(partial_) / name, fs::path(folder_) / name});
  }
  for (const Move& move : planned) {
    std::error_code failure;
    fs::rename(move.from, move.to, failure);
    if (failure) {
      Undo(done);
      return CannotWrite((fs::path(folder_) / move.to.filename()).string(), failure);
    }
    done.push_back(move);
  }
  committed_ = true;
  return Ok();
}

}  // namespace tagtwist
