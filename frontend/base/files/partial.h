#pragma once
#include <string>
#include <vector>

#include "frontend/base/result.h"

namespace tagtwist::internal {

/// A file or folder that takes its place when it is whole. Until then it has a hidden name beside
/// that place, "dir/.name.partial-PID", and is locked: nobody takes it for one that a process left
/// when it was ended. It goes with this object, unless it was put in its place.
class Partial {
 public:
  enum class Kind { kFile, kFolder };
  /// An empty one, made with the rights that umask leaves, never through a link. `ending` is added
  /// to the hidden name: ".mp4". "x.csv: cannot write: Permission denied".
  static Result<Partial> Make(const std::string& path, Kind kind, const std::string& ending = "");
  ~Partial();
  Partial(Partial&& other) noexcept;
  Partial& operator=(Partial&& other) noexcept;
  Partial(const Partial&) = delete;
  Partial& operator=(const Partial&) = delete;

  const std::string& path() const { return path_; }  // the hidden name
  int descriptor() const { return descriptor_; }     // open for writing where it is a file
  /// Puts it in its place, where it stays. 0 or errno. This and the next ask for no memory.
  int PutAt(const std::string& path);
  /// Gives it another name, under which it still goes with this object. 0 or errno.
  int Rename(std::string path);

 private:
  Partial(std::string path, int descriptor) : path_(std::move(path)), descriptor_(descriptor) {}
  void Remove();
  std::string path_;
  int descriptor_ = -1;
};

/// What a Partial for `path` is called in a process, but for a number that may follow.
std::string PartialName(const std::string& path, int process);

/// Removes what processes that were ended have left of partial files or folders for `path`; those
/// of processes that live stay. Returns what went.
std::vector<std::string> RemoveLeftovers(const std::string& path);

/// Removes those of this process, whether they are in use or not: it is about to end.
void RemoveOwnPartials(const std::string& path);

}  // namespace tagtwist::internal
