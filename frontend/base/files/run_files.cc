#include "frontend/base/files/run_files.h"

#include <sys/stat.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

namespace tagtwist::internal {
namespace {

namespace fs = std::filesystem;

std::optional<struct stat> StatOf(const std::string& path) {
  struct stat out = {};
  if (path.empty() || ::stat(path.c_str(), &out) != 0) return std::nullopt;
  return out;
}

std::pair<dev_t, ino_t> IdOf(const struct stat& file) { return {file.st_dev, file.st_ino}; }

// One text for all spellings of a path.
std::string PlaceOf(const std::string& path) {
  std::error_code failure;
  const fs::path place = fs::weakly_canonical(path, failure);
  return failure ? path : place.string();
}

Error Clash(const std::string& path, const std::string& flag, const std::string& reader) {
  return Error{path + ": " + flag + " would overwrite it, but it is read as " + reader +
               ": choose another place for " + flag};
}

bool Has(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

void RunFiles::Reads(const std::string& flag, const std::string& path) {
  const auto file = StatOf(path);
  if (file && S_ISREG(file->st_mode)) read_.emplace(IdOf(*file), flag + " " + path);
}

void RunFiles::ReadsRecording(const std::string& flag, const std::string& path) {
  const auto file = StatOf(path);
  if (file && S_ISDIR(file->st_mode)) unseen_folders_.emplace_back(path, flag + " " + path);
  Reads(flag, path);
}

Status RunFiles::Writes(const std::string& flag, const std::string& path) {
  if (path.empty()) return Ok();
  const auto file = StatOf(path);
  if (file && !S_ISREG(file->st_mode)) return Ok();
  auto reader = ReaderOf(path);
  if (!reader) reader = RecordingOf(path);
  if (reader) return Clash(path, flag, *reader);
  const auto [other, is_new] = written_.emplace(PlaceOf(path), flag);
  if (!is_new) return Error{path + ": " + flag + " and " + other->second + " would both write it"};
  return Ok();
}

Status RunFiles::WritesStandardOutput() {
  const std::string path = "/dev/stdout";
  if (const auto reader = ReaderOf(path)) return Clash(path, "standard output", *reader);
  return Ok();
}

Result<std::vector<std::string>> RunFiles::WritesSet(const std::string& flag,
                                                     const OutputSet& set) {
  const fs::path folder = set.folder;
  const bool has_older_run =
      std::all_of(set.marks.begin(), set.marks.end(), [&](const std::string& name) {
        std::error_code ignored;
        return fs::is_regular_file(folder / name, ignored);
      });
  for (const std::string& name : set.written) {
    const std::string path = (folder / name).string();
    auto reader = ReaderOf(path);
    if (!reader && !has_older_run) reader = RecordingOf(path);
    if (reader) return Clash(path, flag, *reader);
    const auto [other, is_new] = written_.emplace(PlaceOf(path), flag);
    if (!is_new) {
      return Error{path + ": " + flag + " and " + other->second + " would both write it"};
    }
  }
  std::vector<std::string> kept;
  for (const std::string& name : set.obsolete) {
    if (Has(set.written, name)) continue;
    if (!has_older_run || ReaderOf((folder / name).string())) kept.push_back(name);
  }
  return kept;
}

std::optional<std::string> RunFiles::ReaderOf(const std::string& path) const {
  const auto file = StatOf(path);
  if (!file) return std::nullopt;
  const auto found = read_.find(IdOf(*file));
  return found == read_.end() ? std::nullopt : std::optional<std::string>(found->second);
}

std::optional<std::string> RunFiles::RecordingOf(const std::string& path) {
  const auto file = StatOf(path);
  if (!file) return std::nullopt;
  for (const auto& [folder, reader] : unseen_folders_) Walk(folder, reader);
  unseen_folders_.clear();
  const auto found = in_recording_.find(IdOf(*file));
  return found == in_recording_.end() ? std::nullopt : std::optional<std::string>(found->second);
}

void RunFiles::Walk(const std::string& folder, const std::string& reader) {
  std::vector<std::string> waiting = {folder};
  while (!waiting.empty()) {
    const std::string next = waiting.back();
    waiting.pop_back();
    std::error_code failure;
    for (fs::directory_iterator entry(next, failure), end; !failure && entry != end;
         entry.increment(failure)) {
      const std::string path = entry->path().string();
      const auto file = StatOf(path);
      if (!file) continue;
      // A folder that was met before is not entered again: links may lead in circles.
      const bool is_new = in_recording_.emplace(IdOf(*file), reader).second;
      if (is_new && S_ISDIR(file->st_mode)) waiting.push_back(path);
    }
  }
}

}  // namespace tagtwist::internal
