#include "frontend/base/files/file_set.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <system_error>
#include <utility>

#include "frontend/base/files/atomic_file.h"
#include "frontend/base/files/input_file.h"
#include "frontend/base/files/made_folders.h"

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;

// A set that is being put in its place: from the moment that it has this name it is to be finished,
// by whoever comes next if its own process was ended.
constexpr const char* kCommit = ".results.commit";
constexpr const char* kPlan = ".plan";          // in it: what is put where, what goes
constexpr const char* kReplaced = ".replaced";  // in it: what was there before

Error CannotWrite(const std::string& path, const std::string& reason) {
  return Error{path + ": cannot write: " + reason};
}

Error CannotWrite(const std::string& path, const std::error_code& reason) {
  return CannotWrite(path, reason.message());
}

std::string WithoutTrailingSlash(const std::string& folder) {
  fs::path path = fs::path(folder).lexically_normal();
  if (!path.has_filename()) path = path.parent_path();
  return path.empty() ? "." : path.string();
}

// What a set that is in its place leaves in its hidden folder.
std::vector<std::string> WasteIn(const fs::path& hidden, const std::vector<std::string>& replaced) {
  std::vector<std::string> out = {(hidden / kPlan).string()};
  for (const std::string& name : replaced) out.push_back((hidden / kReplaced / name).string());
  out.push_back((hidden / kReplaced).string());
  return out;
}

// Puts in place what an ended process had begun to. Told where something could not be.
Status Finish(const fs::path& folder) {
  const fs::path commit = folder / kCommit;
  const auto text = ReadWholeFile((commit / kPlan).string());
  std::error_code unknown;
  if (!text && !fs::exists(commit, unknown)) return Ok();  // another process was faster
  if (!text) {
    return CannotWrite(folder.string(), commit.string() + " lacks its plan: remove it");
  }
  const CommitPlan plan = ParseCommitPlan(*text);
  for (const std::string& name : plan.put) {
    std::error_code ignored, failure;
    if (!fs::exists(fs::symlink_status(commit / name, ignored))) continue;  // is there already
    fs::rename(commit / name, folder / name, failure);
    if (failure) return CannotWrite((folder / name).string(), failure);
  }
  std::error_code ignored;
  for (const std::string& name : plan.remove) fs::remove(folder / name, ignored);
  FlushToDisk(folder.string());
  // It does not count any more before it goes, file by file.
  const fs::path done = PartialName((folder / "results").string(), ::getpid()) + "-done";
  fs::rename(commit, done, ignored);
  fs::remove_all(done, ignored);
  return Ok();
}

// Waits for another run's commit; finishes one whose run was ended. True where there was one such.
Result<bool> FinishOther(const fs::path& folder) {
  constexpr int kMostWaits = 500;
  for (int i = 0; i < kMostWaits; ++i) {
    const CommitLock lock((folder / kCommit).string());
    if (!lock.is_there()) return false;
    if (lock.Take()) {
      if (const auto finished = Finish(folder); !finished) return finished.error();
      return true;
    }
    ::usleep(10'000);
  }
  return CannotWrite(folder.string(), "another run is at work on it");
}

Status CheckOnce(const std::string& folder, const std::string& path) {
  std::error_code ignored;
  if (fs::exists(path, ignored) && !fs::is_directory(path, ignored)) {
    return Error{folder + ": cannot write: is a file, expected a folder"};
  }
  const std::vector<std::string> missing = MissingFolders(path);
  if (auto made = MakeFolders(missing); !made) return made;
  Status out = Ok();
  {
    const auto probe = Partial::Make(path + "/results", Partial::Kind::kFolder);
    if (!probe) out = Error{folder + probe.error().message.substr(path.size() + 8)};
  }
  RemoveFolders(missing);
  return out;
}

}  // namespace

Status CheckOutputFolder(const std::string& folder) {
  const std::string path = WithoutTrailingSlash(folder);
  return WhileFoldersComeAndGo(path, [&] { return CheckOnce(folder, path); });
}

Result<std::vector<std::string>> RecoverFileSet(const std::string& folder) {
  const std::string path = WithoutTrailingSlash(folder);
  std::vector<std::string> out;
  const auto finished = FinishOther(path);
  if (!finished) return finished.error();
  if (*finished) {
    out.push_back(folder + ": a run was ended while it put its results there: finished now");
  }
  for (const std::string& target : {path, path + "/results"}) {
    for (const std::string& left : RemoveLeftovers(target)) {
      out.push_back(left + ": left by a run that was ended: removed");
    }
  }
  return out;
}

bool IsFileSetWhole(const std::string& folder) {
  std::error_code ignored;
  return !fs::exists(fs::path(folder) / kCommit, ignored);
}

FileSet::FileSet(std::string folder, bool folder_existed, Partial partial)
    : folder_(std::move(folder)), folder_existed_(folder_existed), partial_(std::move(partial)) {}

Result<std::unique_ptr<FileSet>> FileSet::Begin(const std::string& folder) {
  if (auto possible = CheckOutputFolder(folder); !possible) return possible.error();
  const std::string path = WithoutTrailingSlash(folder);
  return WhileFoldersComeAndGo(path, [&]() -> Result<std::unique_ptr<FileSet>> {
    std::error_code ignored;
    const bool existed = fs::exists(path, ignored);
    std::vector<std::string> missing;
    if (!existed) {
      missing = MissingFolders(path);
      missing.pop_back();  // the folder itself appears at Commit
      if (auto made = MakeFolders(missing); !made) return made.error();
    }
    auto partial = Partial::Make(existed ? path + "/results" : path, Partial::Kind::kFolder);
    if (!partial) {
      RemoveFolders(missing);
      return partial.error();
    }
    std::unique_ptr<FileSet> set(new FileSet(path, existed, std::move(*partial)));
    set->made_parents_ = std::move(missing);
    return set;
  });
}

FileSet::~FileSet() {
  { const Partial gone = std::move(partial_); }
  if (!committed_) RemoveFolders(made_parents_);
}

// The partial folder is ours alone to know of: a file is named by where it would have been.
Status FileSet::ToldByItsPlace(const std::string& name, const Status& written) const {
  if (written) return written;
  const size_t length = partial_.path().size() + 1 + name.size();
  return Error{folder_ + "/" + name + written.error().message.substr(length)};
}

Status FileSet::Add(const std::string& name, const std::string& content) {
  const auto written = WriteFileAtomically(partial_.path() + "/" + name, content);
  if (!written) return ToldByItsPlace(name, written);
  names_.push_back(name);
  return Ok();
}

Status FileSet::Append(const std::string& name, std::string_view piece) {
  auto file = growing_.find(name);
  if (file == growing_.end()) {
    auto made = GrowingFile::Make(partial_.path() + "/" + name);
    if (!made) return ToldByItsPlace(name, made.error());
    names_.push_back(name);
    file = growing_.emplace(name, std::move(*made)).first;
  }
  return ToldByItsPlace(name, file->second.Append(piece));
}

Status FileSet::Commit(const std::vector<std::string>& obsolete) {
  for (auto& [name, file] : growing_) {
    if (const Status closed = file.Close(); !closed) return ToldByItsPlace(name, closed);
  }
  for (const std::string& name : names_) {
    const int failure = FlushToDisk(partial_.path() + "/" + name);
    if (failure != 0) {
      return CannotWrite(folder_ + "/" + name, std::generic_category().message(failure));
    }
  }
  if (folder_existed_) return CommitIntoFolder(obsolete);
  FlushToDisk(partial_.path());
  if (const int failure = partial_.PutAt(folder_); failure != 0) {
    return CannotWrite(folder_, std::generic_category().message(failure));
  }
  FlushToDisk(fs::path(folder_).parent_path().empty() ? "."
                                                      : fs::path(folder_).parent_path().string());
  committed_ = true;
  return Ok();
}

// What leaves the folder: files of the same names, and of the obsolete ones.
Result<std::vector<std::string>> FileSet::Leaving(const std::vector<std::string>& obsolete) const {
  std::vector<std::string> candidates = names_, out;
  for (const std::string& name : obsolete) {
    if (std::find(names_.begin(), names_.end(), name) == names_.end()) candidates.push_back(name);
  }
  for (const std::string& name : candidates) {
    const fs::path target = fs::path(folder_) / name;
    std::error_code failure;
    const fs::file_status status = fs::symlink_status(target, failure);
    if (status.type() == fs::file_type::none)
      return CannotWrite(target.string(), failure.message());
    if (fs::is_directory(status)) {
      return CannotWrite(target.string(), "is a folder, expected a file");
    }
    if (fs::exists(status)) out.push_back(name);
  }
  return out;
}

Status FileSet::CommitIntoFolder(const std::vector<std::string>& obsolete) {
  const auto leaving = Leaving(obsolete);
  if (!leaving) return leaving.error();
  CommitPlan plan{names_, {}};
  for (const std::string& name : *leaving) {
    if (std::find(names_.begin(), names_.end(), name) == names_.end()) plan.remove.push_back(name);
  }
  if (auto made = MakeFolders({partial_.path() + "/" + kReplaced}); !made) return made;
  if (auto written = WriteFileAtomically(partial_.path() + "/" + kPlan, FormatCommitPlan(plan));
      !written) {
    return written;
  }
  if (const int failure = FlushToDisk(partial_.path() + "/" + kPlan); failure != 0) {
    return CannotWrite(folder_, std::generic_category().message(failure));
  }
  FlushToDisk(partial_.path());
  const std::string commit = (fs::path(folder_) / kCommit).string();
  const std::vector<FileMove> moves = MovesOf(commit, *leaving);
  std::string own = partial_.path();
  const std::vector<std::string> waste = WasteIn(own, *leaving);
  for (int failure = EEXIST; failure != 0;) {
    if (const auto other = FinishOther(folder_); !other) return other.error();
    failure = partial_.Rename(commit);  // from here on none of it may end half done
    if (failure != 0 && failure != EEXIST && failure != ENOTEMPTY) {
      return CannotWrite(folder_, std::generic_category().message(failure));
    }
  }
  size_t failed = 0;
  FlushToDisk(folder_);
  const int failure = MoveAll(moves, &failed);
  FlushToDisk(folder_);
  // It does not count any more before it goes, file by file.
  partial_.Rename(std::move(own));
  committed_ = failure == 0;
  if (committed_) {
    for (const std::string& path : waste) std::remove(path.c_str());
    return Ok();
  }
  const fs::path place = fs::path(folder_) / fs::path(moves[failed].to).filename();
  return CannotWrite(place.string(), std::generic_category().message(failure));
}

std::vector<FileMove> FileSet::MovesOf(const std::string& commit,
                                       const std::vector<std::string>& leaving) const {
  std::vector<FileMove> out;
  const auto in = [](const std::string& folder, const std::string& name) {
    return (fs::path(folder) / name).string();
  };
  const std::string replaced = in(commit, kReplaced);
  for (const std::string& name : names_) {
    const bool leaves = std::find(leaving.begin(), leaving.end(), name) != leaving.end();
    if (leaves) out.push_back({in(folder_, name), in(replaced, name)});
    out.push_back({in(commit, name), in(folder_, name)});
  }
  for (const std::string& name : leaving) {
    const bool is_new = std::find(names_.begin(), names_.end(), name) != names_.end();
    if (!is_new) out.push_back({in(folder_, name), in(replaced, name)});
  }
  return out;
}

}  // namespace tagtwist::internal
